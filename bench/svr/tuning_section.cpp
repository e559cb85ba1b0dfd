#include <fmt/format.h>

#include "bench/figure.hpp"
#include "bench/stopwatch.hpp"
#include "bench/svr/own_solver.hpp"
#include "bench/svr/replay.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/tuning_material.hpp"

namespace gyrotherm {
namespace {

constexpr double kEvaluations = 620;

struct MeasuredJob {
  double processor_s{};
  double wall_s{};
  TuningSummary summary;
};

Result<MeasuredJob> run_own_job(const TuningMaterial& material, int threads) {
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

/// The same job on two threads.
Result<void> compare_threads(const TuningMaterial& material, const MeasuredJob& one) {
  const auto two = run_own_job(material, 2);
  if (!two) return failure(two.error());
  const bool same =
      one.summary.swarm.history == two->summary.swarm.history && one.summary.swarm.best == two->summary.swarm.best;
  if (!same) say_progress(material.name("one thread and two end differently"));
  print_figure(material.name("whole job, two threads over one, wall clock"), one.wall_s / two->wall_s, at_least(1.8),
               same);
  return {};
}

void say(const TuningMaterial& material, const Replay& replayed) {
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
  const auto material = tuning_material(bench.data, bench.traces, options.set);
  if (!material) return failure(material.error());
  const auto positions = spread_over(material->trace, options.positions);
  say(*material, replay(material->folds, positions, options.without_peer ? nullptr : &bench.peer));
  return {};
}

Result<void> measure_tuning(const Bench& bench, const ReplayOptions& options) {
  const auto material = tuning_material(bench.data, bench.traces, options.set);
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
  const double peer_best = bench.peer.cross_validate(material->folds, material->best().parameters()).error;
  const double worse = job->summary.cross_validation_mse / peer_best;
  print_figure(material->name("whole job, gain over LIBSVM + pagmo (its time from the replay)"),
               job_of_peer_s / job->processor_s, at_least(options.goal), worse <= kBestErrorRatio);
  print_figure(material->name("whole job, s"), job->processor_s, at_most(job_of_peer_s / options.goal));
  print_figure(material->name("whole job, best error / LIBSVM's where pagmo's job ended"), worse,
               at_most(kBestErrorRatio));
  return compare_threads(*material, *job);
}

}  // namespace gyrotherm
