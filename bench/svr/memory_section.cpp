#include <fmt/format.h>

#include "bench/figure.hpp"
#include "bench/stopwatch.hpp"
#include "bench/svr/own_solver.hpp"
#include "bench/svr/sample_set.hpp"
#include "bench/svr/sections.hpp"

namespace gyrotherm {

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
    say_progress(name + ": " + text(solution.error()));
    print_figure(name, {}, at_most(2));
    return {};
  }
  const Verdict verdict = verdict_of(set->x, set->y, hard, solution->beta, solution->b);
  say_progress(fmt::format("n={}: training hard, {:.2f} s of processor, D {:.8g}, gap {:.2e}, {} support vectors",
                           set->y.size(), seconds, verdict.dual, verdict.gap, verdict.support_vectors));
  print_figure(name, bytes / 1e9, at_most(2), verdict.feasible && verdict.gap <= kGap * (1 + 1e-6));
  return {};
}

}  // namespace gyrotherm
