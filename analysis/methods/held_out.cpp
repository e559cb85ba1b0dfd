// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/held_out.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

namespace gyrotherm::methods {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

tl::unexpected<Fault> training_fault(std::string what) {
  return failure(FaultKind::usage, "training", std::move(what));
}

/// Squared errors of one trial on one fold, (°/h)², per candidate.
using Errors = Result<Eigen::VectorXd>;

Errors squared_errors(const Fold& fold, std::size_t index, const Trial& trial) {
  return trial(fold, index).map([&](const Eigen::MatrixXd& predicted) -> Eigen::VectorXd {
    const Eigen::MatrixXd residual = predicted.colwise() - fold.test_y;
    return residual.colwise().squaredNorm().transpose() * (fold.target_scale * fold.target_scale);
  });
}

/// Returns the mean over all rows. The mean is infinite if a fold could not be trained or has predictions that are not
/// finite.
Eigen::VectorXd mean_errors(std::span<const Errors> folds, Eigen::Index rows) {
  Eigen::VectorXd sum;
  for (const Errors& fold : folds) {
    if (!fold) return Eigen::VectorXd::Constant(1, kInfinite);
    if (sum.size() == 0) sum.setZero(fold->size());
    sum += *fold;
  }
  return sum.unaryExpr([&](double total) {
    const double mean = total / static_cast<double>(rows);
    return std::isfinite(mean) ? mean : kInfinite;
  });
}

}  // namespace

bool in_parallel(std::size_t count, int threads, std::string_view stage, const ProgressSink& progress,
                 const std::function<void(std::size_t)>& work) {
  const int available = tbb::info::default_concurrency();
  tbb::task_arena arena(threads == 0 ? available : std::min(threads, available));
  const auto caller = std::this_thread::get_id();
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stopped = false;
  const auto report_progress = [&] {
    return should_continue(progress, stage, static_cast<double>(done) / static_cast<double>(count));
  };
  arena.execute([&] {
    tbb::parallel_for(
        std::size_t{0}, count,
        [&](std::size_t index) {
          if (stopped) return;
          work(index);
          ++done;
          if (std::this_thread::get_id() == caller && !report_progress()) stopped = true;
        },
        tbb::simple_partitioner{});
  });
  return !stopped && report_progress();
}

Result<void> check_set(const FitInput& set, Eigen::Index fewest) {
  if (set.x.cols() == 0) return training_fault("no input");
  if (set.x.rows() != set.y.size()) {
    return training_fault(fmt::format("{} rows of inputs and {} targets", set.x.rows(), set.y.size()));
  }
  if (set.x.rows() < fewest) {
    return training_fault(fmt::format("{} clusters are too few, at least {} are needed", set.x.rows(), fewest));
  }
  if (!set.x.allFinite() || !set.y.allFinite()) return training_fault("a value is not finite");
  return {};
}

Result<std::vector<Eigen::VectorXd>> held_out_errors(std::span<const Fold> folds, std::size_t trials,
                                                     const Trial& trial, const MethodOptions& options,
                                                     const ProgressSink& progress) {
  if (const auto sound = check_folds(folds); !sound) return failure(sound.error());
  std::vector<Errors> all(trials * folds.size());
  const bool finished =
      in_parallel(all.size(), options.tuning.swarm.threads, "choosing on held-out folds", progress,
                  [&](std::size_t i) { all[i] = squared_errors(folds[i % folds.size()], i / folds.size(), trial); });
  if (!finished) return failure(FaultKind::interrupted, "training", "stopped on request");
  Eigen::Index rows = 0;
  for (const Fold& fold : folds) rows += fold.test_y.size();
  std::vector<Eigen::VectorXd> errors;
  for (std::size_t i = 0; i < trials; ++i) {
    errors.push_back(mean_errors(std::span(all).subspan(i * folds.size(), folds.size()), rows));
  }
  const auto known = [](const Eigen::VectorXd& trial_errors) { return trial_errors.array().isFinite().any(); };
  if (std::ranges::any_of(errors, known)) return errors;
  const auto failed = std::ranges::find_if_not(all, &Errors::has_value);
  if (failed != all.end()) return failure(failed->error());
  return failure(FaultKind::numeric, "training", "no candidate has a finite error on the held-out folds");
}

LowestError find_least(const std::vector<Eigen::VectorXd>& errors) {
  LowestError least;
  double value = kInfinite;
  for (std::size_t trial = 0; trial < errors.size(); ++trial) {
    for (Eigen::Index candidate = 0; candidate < errors[trial].size(); ++candidate) {
      if (!(errors[trial](candidate) < value)) continue;
      value = errors[trial](candidate);
      least = {trial, candidate};
    }
  }
  return least;
}

Result<Choice> choose_among(std::span<const HyperParameters> candidates, FitFunction* fit, std::span<const Fold> folds,
                            const MethodOptions& options, const ProgressSink& progress) {
  const Trial refit = [&](const Fold& fold, std::size_t i) -> Result<Eigen::MatrixXd> {
    const auto fitted = fit({fold.train_x, fold.train_y, fold.terms, fold.input_covariance}, candidates[i], options);
    if (!fitted) return failure(fitted.error());
    return evaluate_function(fitted->function, fold.test_x);
  };
  const auto errors = held_out_errors(folds, candidates.size(), refit, options, progress);
  if (!errors) return failure(errors.error());
  Choice choice;
  choice.parameters = candidates[find_least(*errors).trial];
  return choice;
}

}  // namespace gyrotherm::methods
