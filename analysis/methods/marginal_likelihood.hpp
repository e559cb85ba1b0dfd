/// The marginal likelihood of a Gaussian process, its gradient, and the search for its largest value.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Covariance σ_f² exp(−½ Σ_j ((z_j − z'_j)/l_j)²), and noise of variance σ_n² on each target.
struct Covariance {
  Eigen::RowVectorXd lengths;  ///< l
  double signal{};             ///< σ_f
  double noise{};              ///< σ_n
};

/// log l_1 … log l_d, log σ_f, log σ_n: what the search moves in.
[[nodiscard]] Eigen::VectorXd logarithms_of(const Covariance& covariance);
[[nodiscard]] Covariance covariance_of(const Eigen::VectorXd& logarithms);

/// σ_f² exp(…) between the rows of a and b, without noise.
[[nodiscard]] Eigen::MatrixXd covariance_matrix(const Covariance& covariance, const SampleMatrix& a,
                                                const SampleMatrix& b);

struct Likelihood {
  double log_value{};        ///< log p(y | X)
  Eigen::VectorXd gradient;  ///< by the logarithms
};
/// Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), eqs. 5.8 and 5.9. Fails with numeric if the
/// covariance is not positive definite in double.
[[nodiscard]] Result<Likelihood> marginal_likelihood(const Covariance& covariance, const SampleMatrix& x,
                                                     const Eigen::VectorXd& y);

struct Ascent {
  Covariance covariance;
  double log_likelihood{};
  int evaluations{};
};
/// Climbs from a start by Rprop (Blum and Riedmiller, ESANN 2013): the sign of each derivative sets the step of its
/// logarithm; ends after `most` evaluations or when no derivative exceeds 0.05. Lengths stay within 0.05 … 200, σ_f
/// within 0.01 … 100, σ_n within 0.001 … 2. Fails like marginal_likelihood, at the start only.
[[nodiscard]] Result<Ascent> climb_likelihood(const Covariance& start, const SampleMatrix& x, const Eigen::VectorXd& y,
                                              int most);

}  // namespace gyrotherm
