// SPDX-License-Identifier: Apache-2.0
/// A Gaussian process of several axes at once: what one of them shows, another is told as far as they have been seen
/// to go together.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/data/features.hpp"
#include "core/result.hpp"

namespace gyrotherm::population {

// The intrinsic coregionalisation model: the covariance of output i at z with output j at z' is B_ij k(z, z'), k the
// squared exponential with one length per input, and each output has a noise (a nugget) of its own (Bonilla, Chai and
// Williams, Multi-task Gaussian process prediction, NIPS 20 (2008); Álvarez, Rosasco and Lawrence, Kernels for
// vector-valued functions, Found. Trends Mach. Learn. 4 (2012) 195, §4.2).
//
// Where each output has the same rows and no noise, an output's prediction is its own alone and the others drop out
// (autokrigeability: Bonilla et al. §2.3). What is gained is gained through the noise, and where an axis lacks rows
// that another has.

/// One value of one output.
struct OutputValue {
  Eigen::Index row{};     ///< of the inputs
  Eigen::Index output{};  ///< 0 … outputs − 1
  double value{};
};

/// What the process is learnt from: inputs, scaled, and the outputs' values at some of them. Give it what a plane
/// leaves. Each output has a constant of its own beside the process, of which nothing is known before: a mean of values
/// that remember each other is not known well, and that is in the variance.
struct OutputSamples {
  data::SampleMatrix x;
  std::vector<OutputValue> values;
  Eigen::Index outputs{};
};

/// The samples of a table, rows × outputs, with NaN where an output has no value.
[[nodiscard]] OutputSamples samples_of(const data::SampleMatrix& x, const Eigen::MatrixXd& table);

struct Coregionalisation {
  Eigen::RowVectorXd lengths;  ///< one per input, > 0
  Eigen::MatrixXd root;        ///< L of B = LLᵀ, lower triangular, its diagonal above 0; in the outputs' unit
  Eigen::VectorXd noise;       ///< standard deviation of each output's, > 0
};

/// B, outputs × outputs: how the outputs go together.
[[nodiscard]] Eigen::MatrixXd between_outputs(const Coregionalisation& model);
/// B_ij/√(B_ii B_jj).
[[nodiscard]] Eigen::MatrixXd correlation_between_outputs(const Coregionalisation& model);

struct CoregionalisedLikelihood {
  double log_value{};
  /// By log lengths, then the lower triangle of L column by column (its diagonal by the logarithm), then log noise.
  Eigen::VectorXd gradient;
};
/// The likelihood of the values, the outputs' constants integrated out with a flat prior, and its gradient (Rasmussen
/// and Williams, Gaussian Processes for Machine Learning (2006), eq. 2.45). Fails with numeric if the covariance is not
/// positive definite in double.
[[nodiscard]] Result<CoregionalisedLikelihood> marginal_likelihood(const Coregionalisation& model,
                                                                   const OutputSamples& samples);

/// A process that has been learnt: K the covariance of the values, H which output each is of.
struct CoregionalisedGp {
  Coregionalisation model;
  OutputSamples samples;
  Eigen::VectorXd constant;             ///< of each output, β
  Eigen::MatrixXd constant_covariance;  ///< (HᵀK⁻¹H)⁻¹
  Eigen::VectorXd alpha;                ///< K⁻¹(y − Hβ)
  Eigen::MatrixXd factor;               ///< L of K = LLᵀ, lower triangular
  Eigen::MatrixXd of_constants;         ///< L⁻¹H
  double log_likelihood{};
  int evaluations{};
};

struct OutputPredictions {
  Eigen::MatrixXd mean;      ///< rows × outputs
  Eigen::MatrixXd variance;  ///< of the function, without the noise of one value; the same shape
};

/// Learns lengths, B and noises by the marginal likelihood: Rprop from outputs that are taken to be independent, each
/// with half its variance as noise, until no derivative exceeds 0.05 or after `most_evaluations`. Its time goes with
/// the third power of the number of values: give it some hundred. Fails with usage (fewer than two values of an output,
/// a row or an output that is not there, a value that is not finite or that does not vary) or numeric.
[[nodiscard]] Result<CoregionalisedGp> learn_coregionalised(OutputSamples samples, int most_evaluations = 100);

/// Conditions a model that is known on values. Fails as learn_coregionalised does.
[[nodiscard]] Result<CoregionalisedGp> condition(const Coregionalisation& model, OutputSamples samples);

/// Every output at each of the rows, its constant included (Rasmussen and Williams, eqs. 2.41 and 2.42). The rows have
/// the inputs of the samples.
[[nodiscard]] OutputPredictions predict(const CoregionalisedGp& process, const data::SampleMatrix& x);

}  // namespace gyrotherm::population
