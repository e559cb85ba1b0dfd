// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/kernel_methods.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/svm/cholesky.hpp"
#include "core/random.hpp"

namespace gyrotherm::methods {
namespace {

/// Limits the logarithms, which prevents a search from diverging.
Eigen::VectorXd clamp_logarithms(const Eigen::VectorXd& logarithms) {
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

constexpr std::size_t kAscents = 3;
constexpr Eigen::Index kMostSamples = 400;  // for the likelihood
constexpr int kMostEvaluations = 80;

// Fraction of σ_f² added to the diagonal, for samples that are nearly equal.
constexpr double kJitter = 1e-8;

tl::unexpected<Fault> not_definite_fault() {
  return failure(FaultKind::numeric, "Gaussian process", "the covariance is not positive definite");
}

double draw_between(double low, double high, std::mt19937_64& generator) {
  return low * std::pow(high / low, uniform(generator));
}

/// Returns a start of the climb: the first in the middle of the range for standardised data, the others at random
/// around it.
Covariance make_start(std::size_t start, Eigen::Index inputs, std::uint64_t seed) {
  const double middle = std::sqrt(static_cast<double>(inputs));
  if (start == 0) return {.lengths = Eigen::RowVectorXd::Constant(inputs, middle), .signal = 1, .noise = 0.1};
  std::mt19937_64 generator(seed * kAscents + start);
  Covariance covariance{.lengths = Eigen::RowVectorXd(inputs), .signal = 0, .noise = 0};
  for (double& length : covariance.lengths) length = draw_between(0.3 * middle, 5 * middle, generator);
  covariance.signal = draw_between(0.5, 5, generator);
  covariance.noise = draw_between(0.02, 0.5, generator);
  return covariance;
}

Result<Ascent> best_ascent(const data::SampleMatrix& x, const Eigen::VectorXd& y, const MethodOptions& options) {
  std::vector<Result<Ascent>> ascents(options.quick ? 1 : kAscents);
  const bool finished = in_parallel(ascents.size(), options.tuning.swarm.threads, "fitting", {}, [&](std::size_t i) {
    ascents[i] = climb_likelihood(make_start(i, x.cols(), options.seed), x, y, kMostEvaluations);
  });
  assert(finished);
  static_cast<void>(finished);
  std::size_t best = 0;
  for (std::size_t i = 1; i < ascents.size(); ++i) {
    if (!ascents[i]) continue;
    if (!ascents[best] || ascents[i]->log_likelihood > ascents[best]->log_likelihood) best = i;
  }
  return ascents[best];
}

/// Returns every k-th row, with the smallest k that gives at most `most` rows.
std::vector<Eigen::Index> every_kth_row(Eigen::Index rows, Eigen::Index most) {
  const Eigen::Index step = (rows + most - 1) / most;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index row = 0; row < rows; row += step) kept.push_back(row);
  return kept;
}

std::string describe_fit(const Covariance& covariance, const std::vector<data::Term>& terms,
                         const Eigen::VectorXd& deviation, std::size_t samples) {
  std::vector<std::string> lengths;
  for (std::size_t j = 0; j < terms.size(); ++j) {
    lengths.push_back(fmt::format("{} {:.3g}", to_string(terms[j]), covariance.lengths[static_cast<Eigen::Index>(j)]));
  }
  Eigen::VectorXd sorted = deviation;
  std::ranges::sort(sorted);
  return fmt::format(
      "predictive STD in units of the target's STD: median {:.3g} and maximum {:.3g} over the training clusters, "
      "without "
      "the noise of {:.3g}; {:.3g} far from them, without the plane; lengths in units of each input's STD: {}; "
      "likelihood from {} clusters",
      sorted(sorted.size() / 2), sorted(sorted.size() - 1), covariance.noise, covariance.signal,
      fmt::join(lengths, ", "), samples);
}

/// Computes the covariance_matrix of samples with themselves. Only the lower triangle is valid.
Eigen::MatrixXd lower_covariance(const Covariance& covariance, const data::SampleMatrix& x) {
  const data::SampleMatrix scaled = x.array().rowwise() / covariance.lengths.array();
  Eigen::MatrixXd lower = svm::gaussian_kernel_lower(scaled, 1);
  lower.triangularView<Eigen::Lower>() *= covariance.signal * covariance.signal;
  return lower;
}

Result<PredictiveVariance> compute_variance(const FitInput& set, const Covariance& covariance,
                                            const Eigen::MatrixXd& slope_precision) {
  PredictiveVariance stored{.centres = set.x(every_kth_row(set.x.rows(), kVarianceCentres), Eigen::all),
                            .lengths = covariance.lengths,
                            .signal = covariance.signal,
                            .noise = covariance.noise};
  const Eigen::Index inputs = set.x.cols(), count = stored.centres.rows();
  const double signal = covariance.signal * covariance.signal;
  Eigen::MatrixXd kernel = covariance_matrix(covariance, stored.centres, stored.centres);
  kernel.diagonal().array() += kJitter * signal;
  const Eigen::LLT<Eigen::MatrixXd> kernel_llt(kernel);
  if (kernel_llt.info() != Eigen::Success) return not_definite_fault();
  stored.root = kernel_llt.matrixL();

  const Eigen::MatrixXd features = compute_features(stored, set.x);
  const auto unexplained = (signal - features.rightCols(count).rowwise().squaredNorm().array()).max(0);
  const Eigen::VectorXd weights = (unexplained + covariance.noise * covariance.noise).inverse();
  Eigen::MatrixXd precision = features.transpose() * weights.asDiagonal() * features;
  precision.topLeftCorner(inputs, inputs) += slope_precision;
  precision.bottomRightCorner(count, count).diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> whole(precision);
  if (whole.info() != Eigen::Success) return not_definite_fault();
  stored.posterior = whole.solve(Eigen::MatrixXd::Identity(inputs + count, inputs + count));
  return stored;
}

}  // namespace

Eigen::VectorXd to_logarithms(const Covariance& covariance) {
  Eigen::VectorXd all(covariance.lengths.size() + 2);
  all << covariance.lengths.transpose(), covariance.signal, covariance.noise;
  return all.array().log();
}

Covariance from_logarithms(const Eigen::VectorXd& logarithms) {
  const Eigen::Index inputs = logarithms.size() - 2;
  const Eigen::VectorXd all = logarithms.array().exp();
  return {.lengths = all.head(inputs).transpose(), .signal = all(inputs), .noise = all(inputs + 1)};
}

Eigen::MatrixXd covariance_matrix(const Covariance& covariance, const data::SampleMatrix& a,
                                  const data::SampleMatrix& b) {
  const data::SampleMatrix left = a.array().rowwise() / covariance.lengths.array();
  const data::SampleMatrix right = b.array().rowwise() / covariance.lengths.array();
  return covariance.signal * covariance.signal * svm::gaussian_kernel(left, right, 1);
}

Result<Likelihood> marginal_likelihood(const Covariance& covariance, const data::SampleMatrix& x,
                                       const Eigen::VectorXd& y) {
  const Eigen::Index inputs = x.cols();
  const auto samples = static_cast<double>(y.size());
  const double variance = covariance.noise * covariance.noise;
  const Eigen::MatrixXd signal = lower_covariance(covariance, x);
  Eigen::MatrixXd factor = signal;
  factor.diagonal().array() += variance;
  if (!svm::factor_cholesky(factor)) return not_definite_fault();
  Eigen::MatrixXd alpha = y;
  svm::solve_cholesky(factor, alpha);
  Likelihood likelihood{.log_value = -0.5 * y.dot(alpha.col(0)) - factor.diagonal().array().log().sum() -
                                     0.5 * samples * std::log(2 * std::numbers::pi),
                        .gradient = Eigen::VectorXd(inputs + 2)};
  // The gradient is ½ tr((ααᵀ − K⁻¹) ∂K/∂θ). ∂K/∂log l_j is S ∘ (z_j − z'_j)²/l_j², with S the covariance without
  // noise. The trace is therefore a sum of products of Q = (ααᵀ − K⁻¹) ∘ S and x.
  Eigen::MatrixXd weighed = svm::inverse_lower(factor);
  double trace = 0;
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    auto column = weighed.col(j).tail(y.size() - j);
    column = alpha(j, 0) * alpha.col(0).tail(y.size() - j) - column;
    trace += column(0);
    column.array() *= signal.col(j).tail(y.size() - j).array();
  }
  const auto whole = weighed.selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd sums = whole * Eigen::VectorXd::Ones(y.size());
  const Eigen::MatrixXd products = whole * x;
  for (Eigen::Index j = 0; j < inputs; ++j) {
    const double spread = x.col(j).cwiseAbs2().dot(sums) - x.col(j).dot(products.col(j));
    likelihood.gradient(j) = spread / (covariance.lengths(j) * covariance.lengths(j));
  }
  likelihood.gradient(inputs) = sums.sum();
  likelihood.gradient(inputs + 1) = variance * trace;
  return likelihood;
}

RpropSteps::RpropSteps(Eigen::Index coordinates)
    : sizes_(Eigen::VectorXd::Constant(coordinates, 0.2)), before_(Eigen::VectorXd::Zero(coordinates)) {}

Eigen::VectorXd RpropSteps::next(Eigen::VectorXd gradient) {
  constexpr double kLongestStep = 1, kShortestStep = 1e-6, kGrowth = 1.2, kShrinking = 0.5;
  assert(gradient.size() == sizes_.size());
  for (Eigen::Index k = 0; k < gradient.size(); ++k) {
    const double agreement = gradient(k) * before_(k);
    if (agreement > 0) sizes_(k) = std::min(sizes_(k) * kGrowth, kLongestStep);
    if (agreement >= 0) continue;
    sizes_(k) = std::max(sizes_(k) * kShrinking, kShortestStep);
    gradient(k) = 0;
  }
  before_ = gradient;
  return gradient.array().sign() * sizes_.array();
}

Result<Ascent> climb_likelihood(const Covariance& start, const data::SampleMatrix& x, const Eigen::VectorXd& y,
                                int most) {
  constexpr double kFlat = 0.05;  // nats per unit of a logarithm
  Eigen::VectorXd at = clamp_logarithms(to_logarithms(start));
  auto likelihood = marginal_likelihood(from_logarithms(at), x, y);
  if (!likelihood) return failure(likelihood.error());
  Ascent best{.covariance = from_logarithms(at), .log_likelihood = likelihood->log_value, .evaluations = 1};
  RpropSteps steps(at.size());
  while (best.evaluations < most && likelihood->gradient.cwiseAbs().maxCoeff() > kFlat) {
    at = clamp_logarithms(at + steps.next(likelihood->gradient));
    likelihood = marginal_likelihood(from_logarithms(at), x, y);
    ++best.evaluations;
    if (!likelihood) break;
    if (!(likelihood->log_value > best.log_likelihood)) continue;
    best.covariance = from_logarithms(at);
    best.log_likelihood = likelihood->log_value;
  }
  return best;
}

Result<Fit> fit_gaussian_process(const FitInput& set, const HyperParameters&, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const double mean = set.y.mean();
  const Eigen::VectorXd y = set.y.array() - mean;
  const auto kept = every_kth_row(set.x.rows(), kMostSamples);
  const auto ascent = best_ascent(set.x(kept, Eigen::all), plane_residual(set)(kept), options);
  if (!ascent) return failure(ascent.error());
  const Covariance& covariance = ascent->covariance;
  const double variance = covariance.noise * covariance.noise;
  const Eigen::MatrixXd precision = slope_penalty(set, variance);  // A⁻¹
  const Eigen::MatrixXd prior_times_x = precision.llt().solve(set.x.transpose());

  Eigen::MatrixXd factor = lower_covariance(covariance, set.x);
  factor.triangularView<Eigen::Lower>() += set.x * prior_times_x;
  factor.diagonal().array() += variance;
  if (!svm::factor_cholesky(factor)) return not_definite_fault();
  Eigen::MatrixXd alpha = y;
  svm::solve_cholesky(factor, alpha);
  const Eigen::VectorXd diagonal = svm::inverse_diagonal(factor);
  const Eigen::VectorXd deviation = (variance - variance * variance * diagonal.array()).max(0).sqrt();
  auto stored = compute_variance(set, covariance, precision);
  if (!stored) return failure(stored.error());
  return Fit{.function = ExpansionModel{.centres = set.x,
                                        .lengths = covariance.lengths,
                                        .widths = Eigen::VectorXd::Ones(set.x.rows()),
                                        .weights = covariance.signal * covariance.signal * alpha.col(0),
                                        .b = mean,
                                        .slope = prior_times_x * alpha.col(0)},
             .effective_parameters = static_cast<double>(y.size()) - variance * diagonal.sum(),
             .particulars = describe_fit(covariance, set.terms, deviation, kept.size()),
             .variance = std::move(*stored)};
}

}  // namespace gyrotherm::methods
