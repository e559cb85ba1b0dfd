#include "bench/svr/pagmo_job.hpp"

#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/pso.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <utility>

namespace gyrotherm {
namespace {

constexpr unsigned kParticles = 20;
constexpr unsigned kGenerations = 30;
constexpr unsigned kSeed = 42;

// pagmo copies problems: what the copies share stays outside.
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

}  // namespace

std::vector<TracePosition> run_pagmo_job(const PositionFitness& fitness, const EvaluationSink& sink) {
  SharedJob job{.fitness = &fitness, .sink = &sink, .positions = {}};
  pagmo::population swarm{pagmo::problem{TuningProblem{&job}}, kParticles, kSeed};
  pagmo::algorithm{pagmo::pso(kGenerations, 0.7298, 2.05, 2.05, 0.5, 5u, 2u, 4u, false, kSeed)}.evolve(swarm);
  return std::move(job.positions);
}

}  // namespace gyrotherm
