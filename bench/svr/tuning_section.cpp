#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/svr/figure.hpp"
#include "bench/svr/own_solver.hpp"
#include "bench/svr/pagmo_job.hpp"
#include "bench/svr/replay.hpp"
#include "bench/svr/sample_set.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/stopwatch.hpp"
#include "bench/svr/trace.hpp"

namespace gyrotherm {
namespace {

constexpr double kEvaluations = 620;
constexpr double kBestErrorRatio = 1.01;

struct Material {
  SampleSet set;
  std::vector<Fold> folds;
  std::vector<TracePosition> trace;

  [[nodiscard]] double best_error() const { return std::ranges::min_element(trace, {}, &TracePosition::error)->error; }
  [[nodiscard]] std::string name(const std::string& figure) const {
    return fmt::format("n={}: {}", set.y.size(), figure);
  }
};

Result<Material> material_of(const Bench& bench, const std::string& name) {
  auto set = load_sample_set(bench.data, name);
  if (!set) return failure(set.error());
  auto trace = load_trace(bench.traces + "/" + name + ".trace");
  if (!trace) return failure(trace.error());
  auto folds = shuffled_folds(*set);
  return Material{std::move(*set), std::move(folds), std::move(*trace)};
}

struct MeasuredJob {
  double processor_s{};
  double wall_s{};
  TuningSummary summary;
};

Result<MeasuredJob> run_own_job(const Material& material, int threads) {
  const double wall = wall_seconds();
  const double processor = thread_seconds();
  auto summary = tune_svr(material.folds, whole_job(threads));
  if (!summary) return failure(summary.error());
  MeasuredJob job{thread_seconds() - processor, wall_seconds() - wall, std::move(*summary)};
  say_progress(material.name(
      fmt::format("our job, {} thread{}: {:.2f} s of processor, {:.2f} s by the wall, {} "
                  "evaluations, best error {:.6g}, {} not certified",
                  threads, threads == 1 ? "" : "s", job.processor_s, job.wall_s, job.summary.swarm.evaluations,
                  job.summary.cross_validation_mse, job.summary.uncertified)));
  return job;
}

void say(const Material& material, const Replay& replayed) {
  const auto n = static_cast<double>(replayed.positions.size());
  say_progress(material.name(fmt::format(
      "replay of {} positions: LIBSVM {:.2f} s, ours {:.2f} s, gain {:.1f}; LIBSVM's job would take {:.0f} s (standard "
      "error {:.0f} s), the trace's own sum is {:.0f} s",
      n, replayed.peer_seconds(), replayed.own_seconds(), replayed.peer_seconds() / replayed.own_seconds(),
      kEvaluations * replayed.peer_seconds() / n, kEvaluations * replayed.peer_mean_error_s(), [&] {
        double sum = 0;
        for (const auto& p : material.trace) sum += p.seconds;
        return sum;
      }())));
}

}  // namespace

Result<void> measure_replay_alone(const Bench& bench, const ReplayOptions& options) {
  const auto material = material_of(bench, options.set);
  if (!material) return failure(material.error());
  const auto positions = spread_over(material->trace, options.positions);
  say(*material, replay(material->folds, positions, options.without_peer ? nullptr : &bench.peer));
  return {};
}

Result<void> measure_tuning(const Bench& bench, const ReplayOptions& options) {
  const auto material = material_of(bench, options.set);
  if (!material) return failure(material.error());
  const auto positions = spread_over(material->trace, options.positions);
  const Replay replayed = replay(material->folds, positions, &bench.peer);
  say(*material, replayed);
  const double job_of_peer_s = kEvaluations * replayed.peer_seconds() / static_cast<double>(positions.size());
  const int disagreements = replayed.disagreements();
  print_figure(material->name(fmt::format("replay of {} positions, gain over LIBSVM", positions.size())),
               replayed.peer_seconds() / replayed.own_seconds(), at_least(options.goal), disagreements == 0);
  print_figure(material->name("replay, positions of another error (> 0.5 % and farther from the reference)"),
               disagreements, at_most(0));
  const auto job = run_own_job(*material, 1);
  if (!job) return failure(job.error());
  const double worse = job->summary.cross_validation_mse / material->best_error();
  print_figure(material->name("whole job, gain over LIBSVM + pagmo (its time from the replay)"),
               job_of_peer_s / job->processor_s, at_least(options.goal), worse <= kBestErrorRatio);
  print_figure(material->name("whole job, s"), job->processor_s, at_most(job_of_peer_s / options.goal));
  print_figure(material->name("whole job, best error / LIBSVM + pagmo's"), worse, at_most(kBestErrorRatio));
  return {};
}

Result<void> measure_pagmo_job(const Bench& bench, const std::string& set) {
  const auto material = material_of(bench, set);
  if (!material) return failure(material.error());
  int failures = 0;
  double seconds = 0;
  const auto positions = run_pagmo_job([&](const PeerParameters& parameters) {
    const double start = thread_seconds();
    const auto error = cross_validation_error(material->folds, own_parameters(parameters), {.relative_gap = kGap},
                                              std::numeric_limits<double>::infinity());
    seconds += thread_seconds() - start;
    if (!error) ++failures;
    return Evaluated{.error = error ? *error : 1e300, .seconds = 0};
  });
  const double best = std::ranges::min_element(positions, {}, &TracePosition::error)->error;
  say_progress(
      material->name(fmt::format("our fitness in pagmo's job: {:.1f} s, each evaluation prepared anew; best "
                                 "error {:.6g}, LIBSVM's {:.6g}; {} not certified",
                                 seconds, best, material->best_error(), failures)));
  print_figure(material->name("pagmo's job with our fitness, best error / LIBSVM's"), best / material->best_error(),
               at_most(kBestErrorRatio), failures == 0);
  return {};
}

Result<void> measure_threads(const Bench& bench, const std::string& set) {
  const auto material = material_of(bench, set);
  if (!material) return failure(material.error());
  const auto one = run_own_job(*material, 1);
  if (!one) return failure(one.error());
  const auto two = run_own_job(*material, 2);
  if (!two) return failure(two.error());
  const bool same =
      one->summary.swarm.history == two->summary.swarm.history && one->summary.swarm.best == two->summary.swarm.best;
  if (!same) say_progress(material->name("one thread and two end differently"));
  print_figure(material->name("two threads, gain over one (wall clock of our job)"), one->wall_s / two->wall_s,
               at_least(1.8), same);
  return {};
}

Result<void> make_trace(const Bench& bench, const std::string& name) {
  const auto set = load_sample_set(bench.data, name);
  if (!set) return failure(set.error());
  const auto folds = shuffled_folds(*set);
  fmt::print("# {}: pagmo's swarm with LIBSVM {} as fitness, 620 evaluations of five folds.\n", name,
             bench.peer.version());
  fmt::print("# log2 C, log2 gamma, log2 epsilon, mean squared error, processor s\n");
  run_pagmo_job([&](const PeerParameters& parameters) { return bench.peer.cross_validate(folds, parameters); },
                [](const TracePosition& position) {
                  fmt::print("{}", line_of(position));
                  std::fflush(stdout);
                });
  return {};
}

}  // namespace gyrotherm
