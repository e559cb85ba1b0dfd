// SPDX-License-Identifier: Apache-2.0
/// Gaussian process regression (Rasmussen and Williams 2006): squared-exponential covariance with one length per input,
/// which says which inputs matter, and a noise, all by marginal likelihood. One of the two modern methods beside the
/// paper's; the only one here that gives a standard deviation with each prediction.
#pragma once

#include <Eigen/Core>

#include "analysis/methods/method.hpp"
#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm::methods {

/// The covariance σ_f² exp(−½ Σ_j ((z_j − z'_j)/l_j)²), and noise of variance σ_n² on each target.
struct Covariance {
  Eigen::RowVectorXd lengths;  ///< l
  double signal{};             ///< σ_f
  double noise{};              ///< σ_n
};

/// What the search moves in: log l_1 … log l_d, log σ_f, log σ_n.
[[nodiscard]] Eigen::VectorXd logarithms_of(const Covariance& covariance);
[[nodiscard]] Covariance covariance_of(const Eigen::VectorXd& logarithms);

/// The covariance between the rows of a and b, without noise.
[[nodiscard]] Eigen::MatrixXd covariance_matrix(const Covariance& covariance, const data::SampleMatrix& a,
                                                const data::SampleMatrix& b);

struct Likelihood {
  double log_value{};        ///< log p(y | X)
  Eigen::VectorXd gradient;  ///< by the logarithms
};
/// The marginal likelihood of targets y at inputs x, and its gradient (Rasmussen and Williams, Gaussian Processes for
/// Machine Learning (2006), eqs. 5.8 and 5.9). Fails with numeric if the
/// covariance is not positive definite in double.
[[nodiscard]] Result<Likelihood> marginal_likelihood(const Covariance& covariance, const data::SampleMatrix& x,
                                                     const Eigen::VectorXd& y);

struct Ascent {
  Covariance covariance;
  double log_likelihood{};
  int evaluations{};
};
/// Climbs from a start by Rprop (Blum and Riedmiller, ESANN 2013): the sign of each derivative sets the step of its
/// logarithm; ends after `most` evaluations or when no derivative exceeds 0.05. Lengths stay within 0.05 … 200, σ_f
/// within 0.01 … 100, σ_n within 0.001 … 2. Fails like marginal_likelihood, at the start only.
[[nodiscard]] Result<Ascent> climb_likelihood(const Covariance& start, const data::SampleMatrix& x,
                                              const Eigen::VectorXd& y, int most);

/// Nothing is chosen on held-out folds: each fit finds its own covariance by the marginal likelihood of its training
/// samples, and held-out samples choose nothing. The likelihood is climbed from three starts, one in the middle and two
/// at random (quick: from the middle alone), on every k-th sample such that at most 400 remain; the function is then
/// made from all. The prediction falls back to the training mean far from what was seen. The effective parameters are
/// the trace; the particulars name the lengths and the predictive standard deviation. Fails with numeric if no start
/// has a positive definite covariance.
[[nodiscard]] Result<Fit> fit_gaussian_process(const FitInput& set, const HyperParameters& parameters,
                                               const MethodOptions& options);

}  // namespace gyrotherm::methods
