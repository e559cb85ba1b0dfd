// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "analysis/svm/kernel.hpp"
#include "bench/measurement.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/solvers.hpp"
#include "bench/svr/tuning_material.hpp"

namespace gyrotherm::bench {

namespace {

struct TrainingCase {
  const char* name;
  PeerParameters parameters;
  double goal_alone;
  double goal_with_set_up;
  int peer_runs;
};

std::array<TrainingCase, 3> training_cases(const SampleSet& set) {
  const auto inputs = static_cast<double>(set.x.cols());
  return {{{"moderate", {.C = 1, .gamma = 1 / inputs, .epsilon = 0.1}, 20, 10, 3},
           {"hard", {.C = 100, .gamma = 0.1, .epsilon = 0.01}, 20, 20, 3},
           {"very hard", {.C = 10000, .gamma = 0.05, .epsilon = 0.005}, 50, 50, 1}}};
}

struct OwnTraining {
  double alone_s{};
  double with_set_up_s{};
  /// Verdict on the solution with the larger gap of the two trainings.
  Verdict verdict;
};

/// Trains without set-up, from prepared samples as in tuning, and with set-up, from the samples themselves.
Result<OwnTraining> train_own(const SampleSet& set, const PeerParameters& parameters) {
  const svm::SvrParameters own = own_parameters(parameters);
  const svm::SvrOptions options{.relative_gap = kGap};
  const svm::GaussianSamples samples(set.x);
  svm::KernelMemory memory;
  Result<svm::SvrSolution> alone = solve_svr(samples, memory, set.y, own, options);
  Result<svm::SvrSolution> whole = solve_svr(set.x, set.y, own, options);
  if (!alone) return failure(alone.error());
  if (!whole) return failure(whole.error());
  OwnTraining out;
  out.alone_s = median_seconds(3, [&] { alone = solve_svr(samples, memory, set.y, own, options); });
  out.with_set_up_s = median_seconds(3, [&] { whole = solve_svr(set.x, set.y, own, options); });
  const Verdict first = assess_solution(set.x, set.y, parameters, alone->beta, alone->b);
  const Verdict second = assess_solution(set.x, set.y, parameters, whole->beta, whole->b);
  out.verdict = first.gap >= second.gap ? first : second;
  return out;
}

struct PeerTrainingResult {
  double seconds{};
  Verdict verdict;
};

PeerTrainingResult train_peer(const LibsvmPeer& peer, const SampleSet& set, const TrainingCase& training_case) {
  std::vector<double> times;
  PeerSolution solution;
  for (int i = 0; i < training_case.peer_runs; ++i) {
    solution = peer.train(set.x, set.y, training_case.parameters);
    times.push_back(solution.seconds);
  }
  return {median(times), assess_solution(set.x, set.y, training_case.parameters, solution.beta, solution.b)};
}

constexpr double kWorse = 1e-4;

/// Returns the relative excess of the own dual objective D over the peer's; negative if `own` is better.
double relative_excess(const Verdict& own, const Verdict& peer) { return (own.dual - peer.dual) / std::abs(peer.dual); }

/// Returns true if the results are are_equivalent, the condition for comparing times.
bool are_equivalent(const Verdict& own, const Verdict& peer) {
  return own.feasible && relative_excess(own, peer) <= kWorse && own.gap <= kGap;
}

std::string describe(const char* who, double seconds, const Verdict& v) {
  return fmt::format("{} {:.5f} s, D {:.8g}, gap {:.2e}, violation {:.2e}, {} support vectors", who, seconds, v.dual,
                     v.gap, v.violation, v.support_vectors);
}

}  // namespace

Result<void> measure_training(const Bench& bench, const std::string& name) {
  const auto set = load_sample_set(bench.data, name);
  if (!set) return failure(set.error());
  for (const TrainingCase& training_case : training_cases(*set)) {
    const std::string prefix = fmt::format("n={}: training {}", set->y.size(), training_case.name);
    const auto own = train_own(*set, training_case.parameters);
    if (!own) print_progress(prefix + ": ours: " + text(own.error()));
    if (own)
      print_progress(fmt::format("{}: {}, with kernel set-up {:.5f} s", prefix,
                                 describe("ours", own->alone_s, own->verdict), own->with_set_up_s));
    const PeerTrainingResult peer = train_peer(bench.peer, *set, training_case);
    print_progress(fmt::format("{}: {}", prefix, describe("LIBSVM", peer.seconds, peer.verdict)));
    std::optional<double> alone, with_set_up, gap, behind;
    if (own) alone = peer.seconds / own->alone_s;
    if (own) with_set_up = peer.seconds / own->with_set_up_s;
    if (own) gap = own->verdict.gap;
    if (own) behind = relative_excess(own->verdict, peer.verdict);
    const bool same = own && are_equivalent(own->verdict, peer.verdict);
    print_figure(prefix + ", gain over LIBSVM", alone, at_least(training_case.goal_alone), same);
    print_figure(prefix + ", gain with kernel set-up", with_set_up, at_least(training_case.goal_with_set_up), same);
    print_figure(prefix + ", relative gap by the judge", gap, at_most(kGap), own && own->verdict.feasible);
    print_figure(prefix + ", relative excess of D over LIBSVM's", behind, at_most(kWorse));
  }
  const PeerParameters hardest = training_cases(*set).back().parameters;
  const auto tight = solve_svr(set->x, set->y, own_parameters(hardest), {.relative_gap = 0.99 * kReferenceGap});
  if (!tight) print_progress("requested gap of 1e-6: " + text(tight.error()));
  std::optional<double> gap;
  if (tight) gap = assess_solution(set->x, set->y, hardest, tight->beta, tight->b).gap;
  print_figure(fmt::format("n={}: training very hard, relative gap if 1e-6 is requested", set->y.size()), gap,
               at_most(kReferenceGap));
  return {};
}

Result<void> measure_public_set(const Bench& bench, const std::string& name) {
  const auto set = load_sample_set(bench.data, name);
  if (!set) return failure(set.error());
  for (const TrainingCase& training_case : training_cases(*set)) {
    if (training_case.goal_with_set_up > 20) continue;
    const std::string prefix = fmt::format("{} (n={}): training {}", name, set->y.size(), training_case.name);
    const auto own = train_own(*set, training_case.parameters);
    const PeerTrainingResult peer = train_peer(bench.peer, *set, training_case);
    if (!own) print_progress(prefix + ": ours: " + text(own.error()));
    if (own) print_progress(prefix + ": " + describe("ours", own->alone_s, own->verdict));
    print_progress(prefix + ": " + describe("LIBSVM", peer.seconds, peer.verdict));
    std::optional<double> gain;
    if (own) gain = peer.seconds / own->with_set_up_s;
    print_figure(prefix + ", gain with kernel set-up", gain, at_least(training_case.goal_with_set_up),
                 own && are_equivalent(own->verdict, peer.verdict));
  }
  return {};
}

Result<void> measure_memory(const Bench& bench) {
  const PeerParameters hard{.C = 100, .gamma = 0.1, .epsilon = 0.01};
  const auto set = load_sample_set(bench.data, "gyro10000");
  if (!set) return failure(set.error());
  const double start = thread_seconds();
  const auto solution = solve_svr(set->x, set->y, own_parameters(hard), {.relative_gap = kGap});
  const double seconds = thread_seconds() - start;
  const double bytes = peak_memory();
  const std::string name = fmt::format("n={}: training hard, most memory, GB", set->y.size());
  if (!solution) {
    print_progress(name + ": " + text(solution.error()));
    print_figure(name, {}, at_most(2));
    return {};
  }
  const Verdict verdict = assess_solution(set->x, set->y, hard, solution->beta, solution->b);
  print_progress(fmt::format("n={}: training hard, {:.2f} s of processor, D {:.8g}, gap {:.2e}, {} support vectors",
                             set->y.size(), seconds, verdict.dual, verdict.gap, verdict.support_vectors));
  print_figure(name, bytes / 1e9, at_most(2), verdict.feasible && verdict.gap <= kGap * (1 + 1e-6));
  return {};
}

}  // namespace gyrotherm::bench
