// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <random>

#include "analysis/svm/kernel.hpp"
#include "bench/measurement.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/solvers.hpp"
#include "bench/svr/tuning_material.hpp"
#include "core/random.hpp"

namespace gyrotherm::bench {
namespace {

constexpr std::uint64_t kSeed = 20151;

/// Returns true if both the solver and the judge certify the solution.
bool is_certified(const SampleSet& set, const svm::GaussianSamples& samples, svm::KernelMemory& memory,
                  const PeerParameters& parameters, std::string& why) {
  const auto solution = solve_svr(samples, memory, set.y, own_parameters(parameters), {.relative_gap = kGap});
  if (!solution) {
    why = text(solution.error());
    return false;
  }
  const Verdict verdict = assess_solution(set.x, set.y, parameters, solution->beta, solution->b);
  // The judge's kernel differs from the solver's in the last digits.
  if (verdict.feasible && verdict.gap <= kGap * (1 + 1e-6)) return true;
  why = fmt::format("the judge finds a relative gap of {:.3g}{}", verdict.gap, verdict.feasible ? "" : ", infeasible");
  return false;
}

}  // namespace

Result<void> measure_search_box(const Bench& bench, int positions) {
  const auto set = load_sample_set(bench.data, "gyro600");
  if (!set) return failure(set.error());
  const svm::GaussianSamples samples(set->x);
  svm::KernelMemory memory;
  std::mt19937_64 generator(kSeed);
  int failures = 0;
  const double start = thread_seconds();
  for (int i = 1; i <= positions; ++i) {
    const auto draw = [&](double low, double high) { return low + (high - low) * uniform(generator); };
    TracePosition at;
    at.log2_c = draw(-2, 12);
    at.log2_gamma = draw(-8, 3);
    at.log2_epsilon = draw(-8, -1);
    std::string why;
    if (!is_certified(*set, samples, memory, at.parameters(), why)) {
      ++failures;
      print_progress(fmt::format("not certified: C 2^{:.6f} gamma 2^{:.6f} epsilon 2^{:.6f}: {}", at.log2_c,
                                 at.log2_gamma, at.log2_epsilon, why));
    }
    if (i % 1000 == 0)
      print_progress(fmt::format("{} positions of the box, {:.1f} s with judging", i, thread_seconds() - start));
  }
  print_figure(fmt::format("n={}: {} random positions of the search box (seed {}), not certified", set->y.size(),
                           positions, kSeed),
               failures, at_most(0));
  return {};
}

}  // namespace gyrotherm::bench
