// SPDX-License-Identifier: Apache-2.0
/// Measures the tuning job in two ways: a paired replay and the whole job. The replay evaluates each position of a
/// stored job first with LIBSVM and then with this project's solver, because both must see the same state of the
/// machine.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "bench/measurement.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/solvers.hpp"
#include "bench/svr/tuning_material.hpp"

namespace gyrotherm::bench {

namespace {

constexpr double kAgreement = 0.005;
constexpr double kEvaluations = 620;

bool is_near(double a, double b) { return std::abs(a - b) <= kAgreement * std::abs(b); }

struct ReplayedPosition {
  TracePosition position;
  Evaluated peer;
  /// No value if a training missed its certificate.
  std::optional<Evaluated> own;
  /// Error of solutions with a relative gap ≤ 1e-6, if requested and reached.
  std::optional<double> reference;

  /// Returns true if the error is within 0.5 % of the peer's error, or closer to the reference than the peer's error.
  [[nodiscard]] bool agrees() const {
    if (!own) return false;
    if (is_near(own->error, peer.error)) return true;
    return reference && std::abs(own->error - *reference) < std::abs(peer.error - *reference);
  }
};

struct Replay {
  std::vector<ReplayedPosition> positions;

  [[nodiscard]] double peer_seconds() const {
    double sum = 0;
    for (const auto& p : positions) sum += p.peer.seconds;
    return sum;
  }
  /// Returns the total time; infinite if a position was not certified.
  [[nodiscard]] double own_seconds() const {
    double sum = 0;
    for (const auto& p : positions) sum += p.own ? p.own->seconds : std::numeric_limits<double>::infinity();
    return sum;
  }
  /// Returns the standard error of the peer's mean time. Treats the positions as independent draws.
  [[nodiscard]] double peer_mean_error_s() const {
    const auto n = static_cast<double>(positions.size());
    const double mean = peer_seconds() / n;
    double squares = 0;
    for (const auto& p : positions) squares += (p.peer.seconds - mean) * (p.peer.seconds - mean);
    return std::sqrt(squares / (n - 1) / n);
  }
  [[nodiscard]] int disagreements() const {
    return static_cast<int>(std::ranges::count_if(positions, [](const auto& p) { return !p.agrees(); }));
  }
};

void print_position(const ReplayedPosition& p) {
  const auto& at = p.position;
  std::string text = fmt::format("C 2^{:.3f} gamma 2^{:.3f} epsilon 2^{:.3f}: LIBSVM {:.4f} s, error {:.6g}; ",
                                 at.log2_c, at.log2_gamma, at.log2_epsilon, p.peer.seconds, p.peer.error);
  text += p.own ? fmt::format("ours {:.4f} s, error {:+.3f} %, gain {:.1f}", p.own->seconds,
                              100 * (p.own->error / p.peer.error - 1), p.peer.seconds / p.own->seconds)
                : "ours not certified";
  if (p.reference) {
    text += fmt::format("; reference: LIBSVM {:+.3f} %", 100 * (p.peer.error / *p.reference - 1));
    if (p.own) text += fmt::format(", ours {:+.3f} %", 100 * (p.own->error / *p.reference - 1));
  }
  print_progress(text);
}

/// Replays the positions. Without a peer, the trace replaces it; this is useful for examining this project's solver,
/// but not for a figure.
Replay replay(std::span<const svm::TuningFold> folds, std::span<const TracePosition> positions,
              const LibsvmPeer* peer) {
  Replay out;
  for (const TracePosition& position : positions) {
    ReplayedPosition p{.position = position, .peer = {position.error, position.seconds}, .own = {}, .reference = {}};
    if (peer != nullptr) p.peer = peer->cross_validate(folds, position.parameters());
    if (const auto own = cross_validate_own(folds, position)) p.own = *own;
    if (p.own && !is_near(p.own->error, p.peer.error)) {
      const auto reference = reference_error(folds, position.parameters());
      if (reference) p.reference = *reference;
      if (!reference) print_progress("reference solution failed: " + text(reference.error()));
    }
    print_position(p);
    out.positions.push_back(std::move(p));
  }
  return out;
}

struct MeasuredJob {
  double processor_s{};
  double wall_s{};
  svm::TuningSummary summary;
};

Result<MeasuredJob> run_own_job(const TuningMaterial& material, int threads) {
  const double wall = wall_seconds();
  const double processor = thread_seconds();
  auto summary = tune_svr(material.folds, whole_job(threads));
  if (!summary) return failure(summary.error());
  MeasuredJob job{thread_seconds() - processor, wall_seconds() - wall, std::move(*summary)};
  print_progress(material.name(
      fmt::format("our job, {} thread{}: {:.2f} s of processor, {:.2f} s by the wall, {} "
                  "evaluations, best error {:.6g}, {} not certified",
                  threads, threads == 1 ? "" : "s", job.processor_s, job.wall_s, job.summary.swarm.evaluations,
                  job.summary.cross_validation_mse, job.summary.uncertified)));
  return job;
}

/// Runs the job on two threads and compares.
Result<void> compare_threads(const TuningMaterial& material, const MeasuredJob& one) {
  const auto two = run_own_job(material, 2);
  if (!two) return failure(two.error());
  const bool same =
      one.summary.swarm.history == two->summary.swarm.history && one.summary.swarm.best == two->summary.swarm.best;
  if (!same) print_progress(material.name("the results with one and two threads differ"));
  print_figure(material.name("whole job, two threads over one, wall clock"), one.wall_s / two->wall_s, at_least(1.8),
               same);
  return {};
}

void print_replay(const TuningMaterial& material, const Replay& replayed) {
  const auto n = static_cast<double>(replayed.positions.size());
  print_progress(material.name(fmt::format(
      "replay of {} positions: LIBSVM {:.2f} s, ours {:.2f} s, gain {:.1f}; LIBSVM's job would take {:.0f} s (standard "
      "error {:.0f} s); the times in the trace sum to {:.0f} s",
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
  const auto positions = evenly_spaced(material->trace, options.positions);
  print_replay(*material, replay(material->folds, positions, options.without_peer ? nullptr : &bench.peer));
  return {};
}

Result<void> measure_tuning(const Bench& bench, const ReplayOptions& options) {
  const auto material = tuning_material(bench.data, bench.traces, options.set);
  if (!material) return failure(material.error());
  const auto positions = evenly_spaced(material->trace, options.positions);
  const Replay replayed = replay(material->folds, positions, &bench.peer);
  print_replay(*material, replayed);
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
  print_figure(material->name("whole job, best error / LIBSVM's at the best position of pagmo's job"), worse,
               at_most(kBestErrorRatio));
  return compare_threads(*material, *job);
}

}  // namespace gyrotherm::bench
