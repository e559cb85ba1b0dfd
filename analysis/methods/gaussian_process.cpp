#include "analysis/methods/gaussian_process.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/in_parallel.hpp"
#include "analysis/methods/marginal_likelihood.hpp"
#include "analysis/svm/cholesky.hpp"
#include "core/random.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kAscents = 3;
constexpr Eigen::Index kMostSamples = 400;  // for the likelihood
constexpr int kMostEvaluations = 80;

double between(double low, double high, std::mt19937_64& generator) {
  return low * std::pow(high / low, uniform(generator));
}

/// The first in the middle of what standardised data ask for, the others anywhere near.
Covariance start_of(std::size_t start, Eigen::Index inputs, std::uint64_t seed) {
  const double middle = std::sqrt(static_cast<double>(inputs));
  if (start == 0) return {.lengths = Eigen::RowVectorXd::Constant(inputs, middle), .signal = 1, .noise = 0.1};
  std::mt19937_64 generator(seed * kAscents + start);
  Covariance covariance{.lengths = Eigen::RowVectorXd(inputs), .signal = 0, .noise = 0};
  for (double& length : covariance.lengths) length = between(0.3 * middle, 5 * middle, generator);
  covariance.signal = between(0.5, 5, generator);
  covariance.noise = between(0.02, 0.5, generator);
  return covariance;
}

Result<Ascent> best_ascent(const SampleMatrix& x, const Eigen::VectorXd& y, const MethodOptions& options) {
  std::vector<Result<Ascent>> ascents(options.quick ? 1 : kAscents);
  const bool finished = in_parallel(ascents.size(), options.tuning.swarm.threads, "fitting", {}, [&](std::size_t i) {
    ascents[i] = climb_likelihood(start_of(i, x.cols(), options.seed), x, y, kMostEvaluations);
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

/// Every k-th row.
std::vector<Eigen::Index> thinned(Eigen::Index rows) {
  const Eigen::Index step = (rows + kMostSamples - 1) / kMostSamples;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index row = 0; row < rows; row += step) kept.push_back(row);
  return kept;
}

std::string particulars_of(const Covariance& covariance, const std::vector<Term>& terms,
                           const Eigen::VectorXd& deviation, std::size_t samples) {
  std::vector<std::string> lengths;
  for (std::size_t j = 0; j < terms.size(); ++j) {
    lengths.push_back(fmt::format("{} {:.3g}", text(terms[j]), covariance.lengths[static_cast<Eigen::Index>(j)]));
  }
  Eigen::VectorXd sorted = deviation;
  std::ranges::sort(sorted);
  return fmt::format(
      "predictive standard deviation, in the target's STD: {:.3g} in the median and {:.3g} at most over the training "
      "clusters beside a noise of {:.3g}, {:.3g} far from them; lengths, in each input's STD: {}; likelihood of {} "
      "clusters",
      sorted(sorted.size() / 2), sorted(sorted.size() - 1), covariance.noise, covariance.signal,
      fmt::join(lengths, ", "), samples);
}

}  // namespace

Result<Fit> fit_gaussian_process(const FitInput& set, const HyperParameters&, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const double mean = set.y.mean();
  const Eigen::VectorXd y = set.y.array() - mean;
  const auto kept = thinned(set.x.rows());
  const auto ascent = best_ascent(set.x(kept, Eigen::all), y(kept), options);
  if (!ascent) return failure(ascent.error());
  const Covariance& covariance = ascent->covariance;
  const double variance = covariance.noise * covariance.noise;

  Eigen::MatrixXd factor = covariance_matrix(covariance, set.x, set.x);
  factor.diagonal().array() += variance;
  if (!factor_cholesky(factor)) {
    return failure(FaultKind::numeric, "Gaussian process", "the covariance is not positive definite");
  }
  Eigen::MatrixXd alpha = y;
  solve_cholesky(factor, alpha);
  const Eigen::VectorXd diagonal = inverse_diagonal(factor);
  const Eigen::VectorXd deviation = (variance - variance * variance * diagonal.array()).max(0).sqrt();
  return Fit{.function = ExpansionModel{.centres = set.x,
                                        .lengths = covariance.lengths,
                                        .widths = Eigen::VectorXd::Ones(set.x.rows()),
                                        .weights = covariance.signal * covariance.signal * alpha.col(0),
                                        .b = mean},
             .effective_parameters = static_cast<double>(y.size()) - variance * diagonal.sum(),
             .particulars = particulars_of(covariance, set.terms, deviation, kept.size())};
}

}  // namespace gyrotherm
