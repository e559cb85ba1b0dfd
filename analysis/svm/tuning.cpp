// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/tuning.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>

#include "analysis/svm/kernel.hpp"
#include "analysis/svm/spanned.hpp"
#include "analysis/svm/warm_start.hpp"

namespace gyrotherm::svm {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// Returns the training samples of a fold and below them its held-out samples, in coordinates of the space that all of
// them span.
SampleMatrix stack_samples(const TuningFold& fold) {
  SampleMatrix both(fold.train_x.rows() + fold.test_x.rows(), fold.train_x.cols());
  both << fold.train_x, fold.test_x;
  return project_to_span(both);
}

// Fold with its samples laid out for all evaluations.
class PreparedFold {
 public:
  explicit PreparedFold(const TuningFold& fold)
      : fold_(&fold), coordinates_(stack_samples(fold)), samples_(coordinates_.topRows(fold.train_x.rows())) {}

  [[nodiscard]] Eigen::Index held_out() const { return fold_->test_y.size(); }

  // Result of the training at one position. Can be the start for other trainings.
  struct Solution {
    // Sum over all held-out rows, in units of target_scale squared.
    double squared_error{};
    SvrParameters at;
    SvrStart solution;
  };
  [[nodiscard]] Result<Solution> solve(const SvrParameters& parameters, const SvrOptions& options, KernelMemory& memory,
                                       const SvrStart* start) const {
    auto solution = solve_svr(samples_, memory, fold_->train_y, parameters, options, start);
    if (!solution) return failure(solution.error());
    const auto held_out_coordinates = coordinates_.bottomRows(held_out());
    const Eigen::ArrayXd predicted =
        gaussians_at(held_out_coordinates, coordinates_.topRows(samples_.size()), parameters.sigma, solution->beta)
            .array() +
        solution->b;
    return Solution{
        .squared_error = fold_->target_scale * fold_->target_scale * (predicted - fold_->test_y.array()).square().sum(),
        .at = parameters,
        .solution = {std::move(solution->beta), parameters.C}};
  }

 private:
  const TuningFold* fold_;
  SampleMatrix coordinates_;
  GaussianSamples samples_;
};

// All folds, and the mapping from a solution of the first fold to a start of each fold.
struct PreparedFolds {
  explicit PreparedFolds(std::span<const TuningFold> all) : folds(all.begin(), all.end()) {
    for (const TuningFold& fold : all) seeds.push_back(FoldSeed::between(all.front(), fold));
  }
  [[nodiscard]] Eigen::Index held_out() const {
    Eigen::Index rows = 0;
    for (const PreparedFold& fold : folds) rows += fold.held_out();
    return rows;
  }
  std::vector<PreparedFold> folds;
  std::vector<std::optional<FoldSeed>> seeds;
};

using Memories = tbb::enumerable_thread_specific<KernelMemory>;

// Number of threads that are evaluating a position. Towards the end of an iteration of the swarm the other threads are
// idle.
using Workers = std::atomic<int>;

// Last solution of a particle for each fold.
using History = std::vector<std::optional<PreparedFold::Solution>>;

// Greatest distance at which the last solution of a particle is a better start than the solution of another fold or no
// start.
constexpr double kMaxStartDistance_octaves = 2;

// Evaluation of one position on all folds.
class Evaluation {
 public:
  Evaluation(const PreparedFolds& prepared, const SvrParameters& parameters, const SvrOptions& options,
             Memories& memories)
      : prepared_(prepared),
        parameters_(parameters),
        options_(options),
        memories_(memories),
        solved_(prepared.folds.size()) {}

  // Returns the contribution of each fold to the mean over all held-out rows. Proceeds fold by fold and stops when the
  // sum exceeds the limit, since further folds can only increase it. With `all`, evaluates every fold. If threads are
  // idle, the remaining folds run in parallel, some of them needlessly. Updates the history only for the folds up to
  // the limit or up to a failure, so later evaluations depend neither on `all` nor on the threads.
  Result<std::vector<double>> shares(double limit, bool all, History& history, const Workers* workers);

 private:
  [[nodiscard]] Result<PreparedFold::Solution> solve(std::size_t fold, const History& history) const;

  const PreparedFolds& prepared_;
  const SvrParameters& parameters_;
  const SvrOptions& options_;
  Memories& memories_;
  std::vector<Result<PreparedFold::Solution>> solved_;
};

Result<PreparedFold::Solution> Evaluation::solve(std::size_t fold, const History& history) const {
  const PreparedFold& prepared = prepared_.folds[fold];
  const auto begin_at = [&](const SvrStart* start) {
    return prepared.solve(parameters_, options_, memories_.local(), start);
  };
  const auto& last = history[fold];
  if (last && octaves_between(last->at, parameters_) <= kMaxStartDistance_octaves) return begin_at(&last->solution);
  if (fold == 0 || !prepared_.seeds[fold]) return begin_at(nullptr);
  const SvrStart start = prepared_.seeds[fold]->start(solved_.front()->solution);
  return begin_at(&start);
}

Result<std::vector<double>> Evaluation::shares(double limit, bool all, History& history, const Workers* workers) {
  const auto rows = static_cast<double>(prepared_.held_out());
  const std::size_t count = solved_.size();
  std::vector<double> shares;
  std::optional<Fault> fault;
  double mean = 0;
  std::size_t known = 0;
  for (std::size_t f = 0; f < count; ++f) {
    if (f == known) {
      known = f > 0 && workers != nullptr && *workers < tbb::this_task_arena::max_concurrency() ? count : f + 1;
      if (known > f + 1)
        tbb::parallel_for(f, known, [&](std::size_t k) { solved_[k] = solve(k, history); });
      else
        solved_[f] = solve(f, history);
    }
    if (!solved_[f]) {
      fault = solved_[f].error();
      break;
    }
    shares.push_back(solved_[f]->squared_error / rows);
    mean += shares.back();
    if (mean > limit && !all) break;
  }
  mean = 0;
  for (std::size_t f = 0; f < shares.size() && mean <= limit; ++f) {
    mean += shares[f];
    history[f] = std::move(*solved_[f]);
  }
  if (fault) return failure(*fault);
  return shares;
}

double sum_shares(const std::vector<double>& shares) { return std::accumulate(shares.begin(), shares.end(), 0.0); }

// All evaluated positions of a search with their shares. ChoiceRule::one_standard_error requires them. Thread-safe.
class EvaluatedPositions {
 public:
  void add(const std::vector<double>& position, const std::vector<double>& shares) {
    const std::scoped_lock lock(mutex_);
    judged_.push_back({position, shares});
  }
  [[nodiscard]] const std::vector<EvaluatedPosition>& all() const { return judged_; }

 private:
  std::mutex mutex_;
  std::vector<EvaluatedPosition> judged_;
};

// Coordinates of a search: C, σ, and ε unless it is fixed.
struct Coordinates {
  SwarmBox box;
  std::vector<const char*> names;
};

Coordinates search_coordinates(const TuningOptions& options) {
  Coordinates coordinates{.box = {}, .names = {}};
  const auto add = [&](const char* name, const std::pair<double, double>& bounds) {
    coordinates.names.push_back(name);
    coordinates.box.lower.push_back(bounds.first);
    coordinates.box.upper.push_back(bounds.second);
  };
  add("C", options.log2_c);
  add("sigma", options.log2_sigma);
  if (!(options.fixed_epsilon > 0)) add("epsilon", options.log2_epsilon);
  return coordinates;
}

SvrParameters parameters_at(const std::vector<double>& position, const TuningOptions& options) {
  return {.C = std::exp2(position[0]),
          .sigma = std::exp2(position[1]),
          .epsilon = options.fixed_epsilon > 0 ? options.fixed_epsilon : std::exp2(position[2])};
}

// Applies the one-standard-error rule instead of taking the best position of the swarm. Stores the best and the chosen
// position in the summary and returns the chosen one.
std::vector<double> take_simplest(TuningSummary& summary, const std::vector<EvaluatedPosition>& evaluated,
                                  const PreparedFolds& prepared, const TuningOptions& options) {
  std::vector<double> parts;
  for (const PreparedFold& fold : prepared.folds)
    parts.push_back(static_cast<double>(fold.held_out()) / static_cast<double>(prepared.held_out()));
  const OneStandardErrorChoice choice = simplest_within_one_standard_error(evaluated, parts);
  summary.one_standard_error = {.best = parameters_at(evaluated[choice.best].position, options),
                                .best_mse = mean_squared_error(evaluated[choice.best]),
                                .standard_error_mse = choice.standard_error,
                                .within = choice.within};
  summary.best = parameters_at(evaluated[choice.simplest].position, options);
  summary.cross_validation_mse = mean_squared_error(evaluated[choice.simplest]);
  return evaluated[choice.simplest].position;
}

// Returns warnings about coordinates at a bound of their search range and positions without a certificate.
std::vector<std::string> collect_warnings(const std::vector<double>& taken, const Coordinates& coordinates,
                                          int uncertified, int evaluations) {
  const auto& [box, names] = coordinates;
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    if (taken[k] != box.lower[k] && taken[k] != box.upper[k]) continue;
    warnings.push_back(fmt::format("log2 {} = {} is at a bound of its search range", names[k], taken[k]));
  }
  if (uncertified > 0) {
    warnings.push_back(fmt::format("{} of {} positions missed the certificate of optimality and were skipped",
                                   uncertified, evaluations));
  }
  return warnings;
}

}  // namespace

Result<void> check_fold(const TuningFold& fold, std::size_t number) {
  const auto fail = [](std::string what) { return failure(FaultKind::usage, "tuning", std::move(what)); };
  if (fold.train_x.rows() == 0 || fold.test_x.rows() == 0)
    return fail(fmt::format("fold {} has {} training and {} held-out rows, must have both", number, fold.train_x.rows(),
                            fold.test_x.rows()));
  if (fold.train_x.rows() != fold.train_y.size() || fold.test_x.rows() != fold.test_y.size() ||
      fold.train_x.cols() != fold.test_x.cols())
    return fail(fmt::format("fold {}: inputs and targets have different shapes", number));
  if (!fold.train_x.allFinite() || !fold.train_y.allFinite() || !fold.test_x.allFinite() || !fold.test_y.allFinite())
    return fail(fmt::format("fold {} has a value that is not finite", number));
  return {};
}

Result<double> cross_validation_error(std::span<const TuningFold> folds, const SvrParameters& parameters,
                                      const SvrOptions& options, double limit) {
  if (auto ok = check_folds(folds); !ok) return failure(ok.error());
  Memories memories;
  History none(folds.size());
  return Evaluation(PreparedFolds(folds), parameters, options, memories)
      .shares(limit, false, none, nullptr)
      .map(sum_shares);
}

Result<TuningSummary> tune_svr(std::span<const TuningFold> folds, const TuningOptions& options,
                               const ProgressSink& progress) {
  if (auto ok = check_folds(folds); !ok) return failure(ok.error());
  if (!std::isfinite(options.fixed_epsilon))
    return failure(FaultKind::usage, "tuning",
                   fmt::format("fixed_epsilon = {}, must be finite", options.fixed_epsilon));
  const PreparedFolds prepared(folds);
  Memories memories;
  std::atomic<int> uncertified = 0;
  Workers workers = 0;
  const bool evaluates_all = options.choice == ChoiceRule::one_standard_error;
  EvaluatedPositions evaluated;
  std::vector<History> histories(static_cast<std::size_t>(std::max(options.swarm.particles, 0)), History(folds.size()));
  const Fitness fitness = [&](std::size_t particle, const std::vector<double>& position,
                              double limit) -> Result<double> {
    ++workers;
    const SvrParameters parameters = parameters_at(position, options);
    const auto shares = Evaluation(prepared, parameters, options.svr, memories)
                            .shares(limit, evaluates_all, histories[particle], &workers);
    --workers;
    if (shares && evaluates_all) evaluated.add(position, *shares);
    if (shares || shares.error().kind != FaultKind::numeric) return shares.map(sum_shares);
    ++uncertified;
    return kNoLimit;
  };
  const Coordinates coordinates = search_coordinates(options);
  auto swarm = minimise(fitness, coordinates.box, options.swarm, progress);
  if (!swarm) return failure(swarm.error());
  if (!std::isfinite(swarm->best_fitness)) {
    return failure(FaultKind::numeric, "tuning",
                   fmt::format("none of {} positions could be certified", swarm->evaluations));
  }
  // Computes the error of a position by trainings that do not start from the solution of another position. The result
  // is therefore reproducible. If a training fails, keeps the error found by the search.
  tbb::task_arena arena(thread_count(options.swarm));
  const auto replace_error = [&](const SvrParameters& parameters, double& error) -> Result<void> {
    if (!should_continue(progress, "tuning", 1))
      return failure(FaultKind::interrupted, "tuning", "stopped before the final evaluation");
    History none(folds.size());
    const auto shares = arena.execute(
        [&] { return Evaluation(prepared, parameters, options.svr, memories).shares(kNoLimit, true, none, &workers); });
    if (shares) error = sum_shares(*shares);
    return {};
  };
  TuningSummary summary;
  summary.best = parameters_at(swarm->best, options);
  summary.cross_validation_mse = swarm->best_fitness;
  summary.uncertified = uncertified;
  std::vector<double> taken = swarm->best;
  if (evaluates_all) taken = take_simplest(summary, evaluated.all(), prepared, options);
  if (auto done = replace_error(summary.best, summary.cross_validation_mse); !done) return failure(done.error());
  if (auto& rule = summary.one_standard_error)
    if (auto done = replace_error(rule->best, rule->best_mse); !done) return failure(done.error());
  summary.warnings = collect_warnings(taken, coordinates, uncertified, swarm->evaluations);
  summary.swarm = std::move(*swarm);
  return summary;
}

}  // namespace gyrotherm::svm
