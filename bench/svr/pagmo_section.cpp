// SPDX-License-Identifier: Apache-2.0
/// Runs the tuning job of the peer: pagmo's particle swarm over the same box, 20 particles and 30 generations.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/pso.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <tuple>
#include <utility>
#include <vector>

#include "bench/measurement.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/solvers.hpp"
#include "bench/svr/tuning_material.hpp"

namespace gyrotherm::bench {
namespace {

/// Evaluates one position.
using PositionFitness = std::function<Evaluated(const PeerParameters&)>;
/// Receives each evaluation when it is done.
using EvaluationSink = std::function<void(const TracePosition&)>;

constexpr unsigned kParticles = 20;
constexpr unsigned kGenerations = 30;
constexpr unsigned kSwarmSeed = 42;

// State shared by the copies that pagmo makes of a problem.
struct SharedJob {
  const PositionFitness* fitness{};
  const EvaluationSink* sink{};
  std::vector<TracePosition> positions;
};

struct TuningProblem {
  SharedJob* job{};

  [[nodiscard]] pagmo::vector_double fitness(const pagmo::vector_double& at) const {
    TracePosition position{.log2_c = at[0], .log2_gamma = at[1], .log2_epsilon = at[2]};
    const Evaluated evaluated = (*job->fitness)(position.parameters());
    position.error = evaluated.error;
    position.seconds = evaluated.seconds;
    job->positions.push_back(position);
    if (*job->sink) (*job->sink)(position);
    return {evaluated.error};
  }
  [[nodiscard]] std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {{-2, -8, -8}, {12, 3, -1}};
  }
};

/// Runs pagmo::pso with ω = 0.7298, η₁ = η₂ = 2.05, velocity limit 0.5, variant 5, four neighbours, seed 42; box log2 C
/// ∈ [−2, 12], log2 γ ∈ [−8, 3], log2 ε ∈ [−8, −1]. Returns the 620 positions in order.
std::vector<TracePosition> run_pagmo_job(const PositionFitness& fitness, const EvaluationSink& sink = {}) {
  SharedJob job{.fitness = &fitness, .sink = &sink, .positions = {}};
  pagmo::population swarm{pagmo::problem{TuningProblem{&job}}, kParticles, kSwarmSeed};
  pagmo::algorithm{pagmo::pso(kGenerations, 0.7298, 2.05, 2.05, 0.5, 5u, 2u, 4u, false, kSwarmSeed)}.evolve(swarm);
  return std::move(job.positions);
}

// Value for a position without a certificate: pagmo needs a number, and such a position must never be the best.
constexpr double kNeverBest = 1e300;

Evaluated evaluate_own(std::span<const svm::TuningFold> folds, const PeerParameters& parameters) {
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
  print_progress(
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
    fmt::print("{}", trace_line(position));
    std::fflush(stdout);
  });
  return {};
}

}  // namespace gyrotherm::bench
