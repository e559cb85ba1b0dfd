// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/tuning.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>

#include "analysis/svm/kernel.hpp"

namespace gyrotherm::svm {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// The samples of both sides of a fold, the held-out ones below, in the coordinates that they all span.
SampleMatrix places_of(const TuningFold& fold) {
  SampleMatrix both(fold.train_x.rows() + fold.test_x.rows(), fold.train_x.cols());
  both << fold.train_x, fold.test_x;
  return spanned(both);
}

// A fold with its samples laid out for every evaluation.
class PreparedFold {
 public:
  explicit PreparedFold(const TuningFold& fold)
      : fold_(&fold), places_(places_of(fold)), samples_(places_.topRows(fold.train_x.rows())) {
    if (fold.plane_penalty.size() > 0) plane_.emplace(fold.train_x, fold.plane_penalty);
  }

  [[nodiscard]] Eigen::Index held_out() const { return fold_->test_y.size(); }

  // Of all held-out rows, in the units of target_scale squared.
  [[nodiscard]] Result<double> squared_error(const SvrParameters& parameters, const SvrOptions& options,
                                             KernelMemory& memory) const {
    const auto solution = solve_svr(samples_, memory, fold_->train_y, parameters, options, plane_ ? &*plane_ : nullptr);
    if (!solution) return failure(solution.error());
    const auto held_out_places = places_.bottomRows(held_out());
    Eigen::ArrayXd predicted =
        gaussians_at(held_out_places, places_.topRows(samples_.size()), parameters.sigma, solution->beta).array() +
        solution->b;
    if (plane_) predicted += (fold_->test_x * solution->slope).array();
    return fold_->target_scale * fold_->target_scale * (predicted - fold_->test_y.array()).square().sum();
  }

 private:
  const TuningFold* fold_;
  SampleMatrix places_;
  GaussianSamples samples_;
  std::optional<PlaneSamples> plane_;
};

std::vector<PreparedFold> prepare(std::span<const TuningFold> folds) { return {folds.begin(), folds.end()}; }

using Memories = tbb::enumerable_thread_specific<KernelMemory>;

// How many threads have a position of their own. Once a swarm has none left to give, the others are idle.
using Workers = std::atomic<int>;

Eigen::Index held_out(std::span<const PreparedFold> folds) {
  Eigen::Index rows = 0;
  for (const PreparedFold& fold : folds) rows += fold.held_out();
  return rows;
}

// What each fold adds to the mean over all held-out rows, fold after fold until it passes the limit: it can only grow.
// Where threads are idle the folds that are left run at once, some of them in vain; the outcome is the same.
Result<std::vector<double>> squared_errors(std::span<const PreparedFold> folds, const SvrParameters& parameters,
                                           const SvrOptions& options, Memories& memories, double limit,
                                           const Workers* workers) {
  const Eigen::Index rows = held_out(folds);
  const auto error_of = [&](std::size_t f) { return folds[f].squared_error(parameters, options, memories.local()); };
  std::vector<Result<double>> errors(folds.size());
  std::vector<double> shares;
  double mean = 0;
  std::size_t known = 0;
  for (std::size_t f = 0; f < folds.size(); ++f) {
    if (f == known) {
      known = f > 0 && workers != nullptr && *workers < tbb::this_task_arena::max_concurrency() ? folds.size() : f + 1;
      if (known > f + 1)
        tbb::parallel_for(f, known, [&](std::size_t k) { errors[k] = error_of(k); });
      else
        errors[f] = error_of(f);
    }
    if (!errors[f]) return failure(errors[f].error());
    shares.push_back(*errors[f] / static_cast<double>(rows));
    mean += shares.back();
    if (mean > limit) break;
  }
  return shares;
}

double sum_of(const std::vector<double>& shares) { return std::accumulate(shares.begin(), shares.end(), 0.0); }

// Every position of a search with its shares, as one_standard_error needs them; called from several threads.
class JudgedPositions {
 public:
  void add(const std::vector<double>& position, const std::vector<double>& shares) {
    const std::scoped_lock lock(mutex_);
    judged_.push_back({position, shares});
  }
  [[nodiscard]] const std::vector<JudgedPosition>& all() const { return judged_; }

 private:
  std::mutex mutex_;
  std::vector<JudgedPosition> judged_;
};

// The coordinates of a search: C, σ, ε unless it is fixed, κ if there is a plane.
struct Coordinates {
  SwarmBox box;
  std::vector<const char*> names;
  bool plane;
};

Coordinates coordinates_of(const TuningOptions& options, bool plane) {
  Coordinates coordinates{.box = {}, .names = {}, .plane = plane};
  const auto add = [&](const char* name, const std::pair<double, double>& bounds) {
    coordinates.names.push_back(name);
    coordinates.box.lower.push_back(bounds.first);
    coordinates.box.upper.push_back(bounds.second);
  };
  add("C", options.log2_c);
  add("sigma", options.log2_sigma);
  if (options.fixed_epsilon <= 0) add("epsilon", options.log2_epsilon);
  if (plane) add("plane penalty", options.log2_plane_penalty);
  return coordinates;
}

SvrParameters parameters_at(const std::vector<double>& position, const TuningOptions& options, bool plane) {
  return {.C = std::exp2(position[0]),
          .sigma = std::exp2(position[1]),
          .epsilon = options.fixed_epsilon > 0 ? options.fixed_epsilon : std::exp2(position[2]),
          .plane_penalty = plane ? std::exp2(position.back()) : 0};
}

// Takes the simplest position within one standard error instead of the swarm's best, which is kept beside it. Returns
// where it stands.
std::vector<double> take_simplest(TuningSummary& summary, const std::vector<JudgedPosition>& judged,
                                  std::span<const PreparedFold> folds, const TuningOptions& options, bool plane) {
  std::vector<double> parts;
  for (const PreparedFold& fold : folds)
    parts.push_back(static_cast<double>(fold.held_out()) / static_cast<double>(held_out(folds)));
  const OneStandardErrorChoice choice = simplest_within_one_standard_error(judged, parts);
  summary.one_standard_error = {.best = parameters_at(judged[choice.best].position, options, plane),
                                .best_mse = mean_squared_error(judged[choice.best]),
                                .standard_error_mse = choice.standard_error,
                                .within = choice.within};
  summary.best = parameters_at(judged[choice.simplest].position, options, plane);
  summary.cross_validation_mse = mean_squared_error(judged[choice.simplest]);
  return judged[choice.simplest].position;
}

// The lower edge of κ is no shortage of room: it is the certificate.
std::vector<std::string> warnings_of(const std::vector<double>& taken, const Coordinates& coordinates, int uncertified,
                                     int evaluations) {
  const auto& [box, names, plane] = coordinates;
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    const bool certificate = plane && k + 1 == taken.size();
    if ((taken[k] != box.lower[k] || certificate) && taken[k] != box.upper[k]) continue;
    warnings.push_back(fmt::format("log2 {} = {} lies on the edge of its box", names[k], taken[k]));
  }
  if (uncertified > 0) {
    warnings.push_back(fmt::format("{} of {} positions missed the certificate of optimality and were passed over",
                                   uncertified, evaluations));
  }
  return warnings;
}

}  // namespace

Result<void> check_fold(const TuningFold& fold, std::size_t number) {
  const auto wrong = [](std::string what) { return failure(FaultKind::usage, "tuning", std::move(what)); };
  if (fold.train_x.rows() == 0 || fold.test_x.rows() == 0)
    return wrong(fmt::format("fold {} has {} training and {} held-out rows, must have both", number,
                             fold.train_x.rows(), fold.test_x.rows()));
  if (fold.train_x.rows() != fold.train_y.size() || fold.test_x.rows() != fold.test_y.size() ||
      fold.train_x.cols() != fold.test_x.cols())
    return wrong(fmt::format("fold {}: inputs and targets have different shapes", number));
  if (!fold.train_x.allFinite() || !fold.train_y.allFinite() || !fold.test_x.allFinite() || !fold.test_y.allFinite())
    return wrong(fmt::format("fold {} has a value that is not finite", number));
  if (fold.plane_penalty.size() > 0 &&
      (fold.plane_penalty.rows() != fold.train_x.cols() || fold.plane_penalty.cols() != fold.train_x.cols()))
    return wrong(fmt::format("fold {} has a penalty that is not of its {} inputs", number, fold.train_x.cols()));
  return {};
}

Result<double> cross_validation_error(std::span<const TuningFold> folds, const SvrParameters& parameters,
                                      const SvrOptions& options, double limit) {
  if (auto ok = check_folds(folds); !ok) return failure(ok.error());
  Memories memories;
  return squared_errors(prepare(folds), parameters, options, memories, limit, nullptr).map(sum_of);
}

Result<TuningSummary> tune_svr(std::span<const TuningFold> folds, const TuningOptions& options,
                               const ProgressSink& progress) {
  if (auto ok = check_folds(folds); !ok) return failure(ok.error());
  const std::vector<PreparedFold> prepared = prepare(folds);
  Memories memories;
  std::atomic<int> uncertified = 0;
  Workers workers = 0;
  const bool judges_all = options.choice == ChoiceRule::one_standard_error;
  JudgedPositions judged;
  const bool plane = folds.front().plane_penalty.size() > 0;
  const Fitness fitness = [&](const std::vector<double>& position, double limit) -> Result<double> {
    ++workers;
    const auto shares = squared_errors(prepared, parameters_at(position, options, plane), options.svr, memories,
                                       judges_all ? kNoLimit : limit, &workers);
    --workers;
    if (shares && judges_all) judged.add(position, *shares);
    if (shares || shares.error().kind != FaultKind::numeric) return shares.map(sum_of);
    ++uncertified;
    return kNoLimit;
  };
  const Coordinates coordinates = coordinates_of(options, plane);
  auto swarm = minimise(fitness, coordinates.box, options.swarm, progress);
  if (!swarm) return failure(swarm.error());
  if (!std::isfinite(swarm->best_fitness)) {
    return failure(FaultKind::numeric, "tuning",
                   fmt::format("none of {} positions could be certified", swarm->evaluations));
  }
  TuningSummary summary;
  summary.best = parameters_at(swarm->best, options, plane);
  summary.cross_validation_mse = swarm->best_fitness;
  summary.uncertified = uncertified;
  std::vector<double> taken = swarm->best;
  if (judges_all) taken = take_simplest(summary, judged.all(), prepared, options, plane);
  summary.warnings = warnings_of(taken, coordinates, uncertified, swarm->evaluations);
  summary.swarm = std::move(*swarm);
  return summary;
}

}  // namespace gyrotherm::svm
