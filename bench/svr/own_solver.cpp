#include "bench/svr/own_solver.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "bench/stopwatch.hpp"

namespace gyrotherm {
namespace {

// log2 σ = −½(1 + log2 γ).
double log2_sigma(double log2_gamma) { return -0.5 * (1 + log2_gamma); }

}  // namespace

TuningOptions whole_job(int threads) {
  TuningOptions options;
  options.swarm.stall_iterations = options.swarm.iterations + 1;
  options.swarm.threads = threads;
  return options;
}

Result<Evaluated> cross_validate_own(std::span<const TuningFold> folds, const TracePosition& position) {
  constexpr double kWidth = 1e-9;
  const double sigma = log2_sigma(position.log2_gamma);
  TuningOptions options = whole_job(1);
  options.log2_c_min = position.log2_c;
  options.log2_c_max = position.log2_c + kWidth;
  options.log2_sigma_min = sigma;
  options.log2_sigma_max = sigma + kWidth;
  options.log2_epsilon_min = position.log2_epsilon;
  options.log2_epsilon_max = position.log2_epsilon + kWidth;
  options.swarm.particles = 2;
  options.swarm.iterations = 0;
  options.svr.relative_gap = kGap;
  std::vector<double> done;
  const auto summary = tune_svr(folds, options, [&](std::string_view, double) {
    done.push_back(thread_seconds());
    return true;
  });
  if (!summary) return failure(summary.error());
  if (summary->uncertified > 0 || done.size() < 2)
    return failure(FaultKind::numeric, "tuning", fmt::format("{} of 2 not certified", summary->uncertified));
  return Evaluated{.error = summary->cross_validation_mse, .seconds = done[1] - done[0]};
}

Result<double> reference_error(std::span<const TuningFold> folds, const PeerParameters& parameters) {
  double squared = 0;
  Eigen::Index rows = 0;
  for (const TuningFold& fold : folds) {
    const auto solution =
        solve_svr(fold.train_x, fold.train_y, own_parameters(parameters), {.relative_gap = 0.9 * kReferenceGap});
    if (!solution) return failure(solution.error());
    const Verdict verdict = verdict_of(fold.train_x, fold.train_y, parameters, solution->beta, solution->b);
    if (!verdict.feasible || !(verdict.gap <= kReferenceGap))
      return failure(FaultKind::numeric, "reference", fmt::format("relative gap {:.2g}", verdict.gap));
    squared +=
        (plain_prediction(fold.train_x, solution->beta, solution->b, parameters.gamma, fold.test_x) - fold.test_y)
            .squaredNorm();
    rows += fold.test_y.size();
  }
  return squared / static_cast<double>(rows);
}

}  // namespace gyrotherm
