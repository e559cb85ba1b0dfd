#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "bench/figure.hpp"
#include "bench/stopwatch.hpp"
#include "bench/svr/own_solver.hpp"
#include "bench/svr/pagmo_job.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/tuning_material.hpp"

namespace gyrotherm {
namespace {

// pagmo wants a number of every position; one that misses its certificate must never be a best one.
constexpr double kNeverBest = 1e300;

Evaluated evaluate_own(std::span<const TuningFold> folds, const PeerParameters& parameters) {
  const double start = thread_seconds();
  const auto error = cross_validation_error(folds, own_parameters(parameters), {.relative_gap = kGap},
                                            std::numeric_limits<double>::infinity());
  return {.error = error ? *error : kNeverBest, .seconds = thread_seconds() - start};
}

}  // namespace

Result<void> measure_pagmo_job(const Bench& bench, const std::string& name) {
  const auto material = tuning_material(bench.data, bench.traces, name);
  if (!material) return failure(material.error());
  const auto positions =
      run_pagmo_job([&](const PeerParameters& parameters) { return evaluate_own(material->folds, parameters); });
  const auto failures = std::ranges::count(positions, kNeverBest, &TracePosition::error);
  const double best = std::ranges::min_element(positions, {}, &TracePosition::error)->error;
  double seconds = 0;
  for (const TracePosition& position : positions) seconds += position.seconds;
  say_progress(
      material->name(fmt::format("our fitness in pagmo's job: {:.1f} s, each evaluation prepared anew; best "
                                 "error {:.6g}, the trace's {:.6g}; {} not certified",
                                 seconds, best, material->best().error, failures)));
  print_figure(material->name("pagmo's job with our fitness, best error / the stored job's"),
               best / material->best().error, at_most(kBestErrorRatio), failures == 0);
  return {};
}

Result<void> make_trace(const Bench& bench, const std::string& name, bool own) {
  const auto set = load_sample_set(bench.data, name);
  if (!set) return failure(set.error());
  const auto folds = shuffled_folds(*set);
  fmt::print("# {}: pagmo's swarm, fitness by {}, 620 evaluations of five folds.\n", name,
             own ? "gyrotherm" : fmt::format("LIBSVM {}", bench.peer.version()));
  fmt::print("# log2 C, log2 gamma, log2 epsilon, mean squared error, processor s\n");
  const auto fitness = [&](const PeerParameters& parameters) {
    return own ? evaluate_own(folds, parameters) : bench.peer.cross_validate(folds, parameters);
  };
  std::ignore = run_pagmo_job(fitness, [](const TracePosition& position) {
    fmt::print("{}", line_of(position));
    std::fflush(stdout);
  });
  return {};
}

}  // namespace gyrotherm
