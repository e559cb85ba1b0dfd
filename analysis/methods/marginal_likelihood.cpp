#include "analysis/methods/marginal_likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/svm/cholesky.hpp"

namespace gyrotherm {
namespace {

/// Limits of the logarithms, so that no search ends in infinity.
Eigen::VectorXd clamped(const Eigen::VectorXd& logarithms) {
  const Eigen::Index inputs = logarithms.size() - 2;
  Eigen::VectorXd out = logarithms;
  const auto clamp = [](double value, double low, double high) {
    return std::clamp(value, std::log(low), std::log(high));
  };
  for (Eigen::Index j = 0; j < inputs; ++j) out(j) = clamp(out(j), 0.05, 200);
  out(inputs) = clamp(out(inputs), 0.01, 100);
  out(inputs + 1) = clamp(out(inputs + 1), 0.001, 2);
  return out;
}

/// The steps of Rprop, one per logarithm.
class Steps {
 public:
  explicit Steps(Eigen::Index count)
      : sizes_(Eigen::VectorXd::Constant(count, kFirst)), before_(Eigen::VectorXd::Zero(count)) {}

  /// Longer where a derivative keeps its sign, half and no move where it turned.
  [[nodiscard]] Eigen::VectorXd next(Eigen::VectorXd gradient) {
    for (Eigen::Index k = 0; k < gradient.size(); ++k) {
      const double agreement = gradient(k) * before_(k);
      if (agreement > 0) sizes_(k) = std::min(sizes_(k) * 1.2, kLongest);
      if (agreement >= 0) continue;
      sizes_(k) = std::max(sizes_(k) * 0.5, kShortest);
      gradient(k) = 0;
    }
    before_ = gradient;
    return gradient.array().sign() * sizes_.array();
  }

 private:
  static constexpr double kFirst = 0.2, kLongest = 1, kShortest = 1e-6;
  Eigen::VectorXd sizes_, before_;
};

}  // namespace

Eigen::VectorXd logarithms_of(const Covariance& covariance) {
  Eigen::VectorXd all(covariance.lengths.size() + 2);
  all << covariance.lengths.transpose(), covariance.signal, covariance.noise;
  return all.array().log();
}

Covariance covariance_of(const Eigen::VectorXd& logarithms) {
  const Eigen::Index inputs = logarithms.size() - 2;
  const Eigen::VectorXd all = logarithms.array().exp();
  return {.lengths = all.head(inputs).transpose(), .signal = all(inputs), .noise = all(inputs + 1)};
}

Eigen::MatrixXd covariance_matrix(const Covariance& covariance, const SampleMatrix& a, const SampleMatrix& b) {
  const SampleMatrix left = a.array().rowwise() / covariance.lengths.array();
  const SampleMatrix right = b.array().rowwise() / covariance.lengths.array();
  return covariance.signal * covariance.signal * gaussian_kernel(left, right, 1);
}

Result<Likelihood> marginal_likelihood(const Covariance& covariance, const SampleMatrix& x, const Eigen::VectorXd& y) {
  const Eigen::Index inputs = x.cols();
  const auto samples = static_cast<double>(y.size());
  const double variance = covariance.noise * covariance.noise;
  const Eigen::MatrixXd signal = covariance_matrix(covariance, x, x);
  Eigen::MatrixXd factor = signal;
  factor.diagonal().array() += variance;
  if (!factor_cholesky(factor)) {
    return failure(FaultKind::numeric, "Gaussian process", "the covariance is not positive definite");
  }
  Eigen::MatrixXd alpha = y;
  solve_cholesky(factor, alpha);
  Likelihood likelihood{.log_value = -0.5 * y.dot(alpha.col(0)) - factor.diagonal().array().log().sum() -
                                     0.5 * samples * std::log(2 * std::numbers::pi),
                        .gradient = Eigen::VectorXd(inputs + 2)};
  // ½ tr((ααᵀ − K⁻¹) ∂K/∂θ); ∂K/∂log l_j is S ∘ (z_j − z'_j)²/l_j², which sums to products of Q = (ααᵀ − K⁻¹) ∘ S with
  // x.
  const Eigen::MatrixXd lower = inverse_lower(factor);
  Eigen::MatrixXd weighed = lower.selfadjointView<Eigen::Lower>();
  weighed = alpha * alpha.transpose() - weighed;
  const double trace = weighed.trace();
  weighed.array() *= signal.array();
  const Eigen::VectorXd sums = weighed.rowwise().sum();
  const Eigen::MatrixXd products = weighed * x;
  for (Eigen::Index j = 0; j < inputs; ++j) {
    const double spread = x.col(j).cwiseAbs2().dot(sums) - x.col(j).dot(products.col(j));
    likelihood.gradient(j) = spread / (covariance.lengths(j) * covariance.lengths(j));
  }
  likelihood.gradient(inputs) = sums.sum();
  likelihood.gradient(inputs + 1) = variance * trace;
  return likelihood;
}

Result<Ascent> climb_likelihood(const Covariance& start, const SampleMatrix& x, const Eigen::VectorXd& y, int most) {
  constexpr double kFlat = 0.05;  // nats per unit of a logarithm
  Eigen::VectorXd at = clamped(logarithms_of(start));
  auto likelihood = marginal_likelihood(covariance_of(at), x, y);
  if (!likelihood) return failure(likelihood.error());
  Ascent best{.covariance = covariance_of(at), .log_likelihood = likelihood->log_value, .evaluations = 1};
  Steps steps(at.size());
  while (best.evaluations < most && likelihood->gradient.cwiseAbs().maxCoeff() > kFlat) {
    at = clamped(at + steps.next(likelihood->gradient));
    likelihood = marginal_likelihood(covariance_of(at), x, y);
    ++best.evaluations;
    if (!likelihood) break;
    if (!(likelihood->log_value > best.log_likelihood)) continue;
    best.covariance = covariance_of(at);
    best.log_likelihood = likelihood->log_value;
  }
  return best;
}

}  // namespace gyrotherm
