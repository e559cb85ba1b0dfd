// SPDX-License-Identifier: Apache-2.0
/// A Gaussian process of several axes: data of one axis improve the prediction of another axis if the two are
/// correlated.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/data/features.hpp"
#include "core/result.hpp"

namespace gyrotherm::population {

// The intrinsic coregionalisation model: the covariance of output i at z with output j at z' is B_ij k(z, z'), where k
// is the squared exponential with one length per input. Each output has its own noise (nugget) (Bonilla, Chai and
// Williams, Multi-task Gaussian process prediction, NIPS 20 (2008); Álvarez, Rosasco and Lawrence, Kernels for
// vector-valued functions, Found. Trends Mach. Learn. 4 (2012) 195, §4.2).
//
// If all outputs have the same rows and no noise, the prediction of an output depends only on its own values
// (autokrigeability: Bonilla et al. §2.3). Joint learning helps only if there is noise, or if an axis has no values in
// rows in which another axis has some.

/// One value of one output.
struct OutputValue {
  Eigen::Index row{};     ///< row of the inputs
  Eigen::Index output{};  ///< 0 … outputs − 1
  double value{};
};

/// Training data of the process: scaled inputs, and the outputs' values at some of their rows. The values should be the
/// residuals of a plane. Each output also has a constant with a flat prior. The predicted variance includes the
/// uncertainty of the constant, which is large for correlated values.
struct OutputSamples {
  data::SampleMatrix x;
  std::vector<OutputValue> values;
  Eigen::Index outputs{};
};

/// Converts a table, rows × outputs, with NaN for missing values.
[[nodiscard]] OutputSamples samples_from_table(const data::SampleMatrix& x, const Eigen::MatrixXd& table);

struct Coregionalisation {
  Eigen::RowVectorXd lengths;  ///< one per input, > 0
  /// L of B = LLᵀ, lower triangular with positive diagonal, in the outputs' unit.
  Eigen::MatrixXd root;
  /// Standard deviation of the noise of each output, > 0.
  Eigen::VectorXd noise;
};

/// Returns B, outputs × outputs, the covariance between the outputs.
[[nodiscard]] Eigen::MatrixXd output_covariance(const Coregionalisation& model);
/// Returns B_ij/√(B_ii B_jj).
[[nodiscard]] Eigen::MatrixXd correlation_between_outputs(const Coregionalisation& model);

struct CoregionalisedLikelihood {
  double log_value{};
  /// Gradient with respect to the log lengths, the lower triangle of L column by column (for the diagonal, its
  /// logarithm), and the log noises, in this order.
  Eigen::VectorXd gradient;
};
/// Computes the likelihood of the values and its gradient, with the constants of the outputs integrated out under a
/// flat prior (Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), eq. 2.45). Fails with numeric if
/// the covariance is not positive definite in double precision.
[[nodiscard]] Result<CoregionalisedLikelihood> marginal_likelihood(const Coregionalisation& model,
                                                                   const OutputSamples& samples);

/// A learnt process. K is the covariance of the values, H assigns each value to its output.
struct CoregionalisedGp {
  Coregionalisation model;
  OutputSamples samples;
  Eigen::VectorXd constant;             ///< per output, β
  Eigen::MatrixXd constant_covariance;  ///< (HᵀK⁻¹H)⁻¹
  Eigen::VectorXd alpha;                ///< K⁻¹(y − Hβ)
  /// L of K = LLᵀ, lower triangular.
  Eigen::MatrixXd factor;
  Eigen::MatrixXd of_constants;  ///< L⁻¹H
  double log_likelihood{};
  int evaluations{};
};

struct OutputPredictions {
  Eigen::MatrixXd mean;  ///< rows × outputs
  /// Variance of the function, without the noise of a single value; rows × outputs.
  Eigen::MatrixXd variance;
};

/// Learns lengths, B and noises by maximising the marginal likelihood with Rprop. The search starts from independent
/// outputs with half their variance as noise, and ends when no derivative exceeds 0.05 or after `most_evaluations`. The
/// computing time grows with the third power of the number of values; a few hundred values are practical. Fails with
/// usage for an output with fewer than two values, an invalid row or output, or values that are not finite or do not
/// vary. Fails with numeric.
[[nodiscard]] Result<CoregionalisedGp> learn_coregionalised(OutputSamples samples, int most_evaluations = 100);

/// Conditions a known model on values. Fails like learn_coregionalised().
[[nodiscard]] Result<CoregionalisedGp> condition(const Coregionalisation& model, OutputSamples samples);

/// Predicts every output, including its constant, at each row of `x` (Rasmussen and Williams, eqs. 2.41 and 2.42). The
/// columns of `x` must be the inputs of the samples.
[[nodiscard]] OutputPredictions predict(const CoregionalisedGp& process, const data::SampleMatrix& x);

}  // namespace gyrotherm::population
