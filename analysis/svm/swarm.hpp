// SPDX-License-Identifier: Apache-2.0
/// Particle swarm optimisation by eqs. 8–10 of the paper (with errata 2 for their order): inertia weight falling
/// linearly, velocity limit before the move, positions clamped to the box with that velocity component set to zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::svm {

struct SwarmOptions {
  int particles = 20;
  int iterations = 30;        ///< T_max of eq. 10; the initial swarm is evaluated before the first
  double omega_max = 0.9;     ///< eq. 10
  double omega_min = 0.4;     ///< eq. 10
  double c1 = 2.0;            ///< eq. 9
  double c2 = 2.0;            ///< eq. 9
  double v_max = 0.2;         ///< of each coordinate's range
  int stall_iterations = 10;  ///< stop early after so many iterations without `stall_gain`
  double stall_gain = 1e-3;   ///< relative gain of the best fitness that counts
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all. The result does not depend on it
};

/// Where a swarm may go.
struct SwarmBox {
  std::vector<double> lower;  ///< per coordinate
  std::vector<double> upper;
};

enum class SwarmEnd { was_not_run, iterations_done, stalled };
inline constexpr std::initializer_list<SwarmEnd> kSwarmEnds = {SwarmEnd::was_not_run, SwarmEnd::iterations_done,
                                                               SwarmEnd::stalled};

/// What a swarm found, and why it ended.
struct SwarmSummary {
  SwarmEnd end = SwarmEnd::was_not_run;
  std::vector<double> best;              ///< position
  double best_fitness{};                 ///< lowest
  std::vector<double> history;           ///< best fitness after the initial swarm and after each iteration
  std::vector<int> coordinates_on_edge;  ///< coordinates of the best that lie on the box's edge
  int evaluations{};
};

[[nodiscard]] const char* name(SwarmEnd end);

void describe(auto& form, Like<SwarmSummary> auto& swarm) {
  form("end", one_of(swarm.end, kSwarmEnds));
  form("best", swarm.best);
  form("best_fitness", swarm.best_fitness);
  form("history", swarm.history);
  form("coordinates_on_edge", swarm.coordinates_on_edge);
  form("evaluations", swarm.evaluations);
}

void describe(auto& form, Like<SwarmOptions> auto& swarm) {
  form("particles", swarm.particles);
  form("iterations", swarm.iterations);
  form("omega_max", swarm.omega_max);
  form("omega_min", swarm.omega_min);
  form("c1", swarm.c1);
  form("c2", swarm.c2);
  form("v_max", swarm.v_max);
  form("stall_iterations", swarm.stall_iterations);
  form("stall_gain", swarm.stall_gain);
  form("seed", swarm.seed);
}

/// `fitness(particle, position, limit)` returns the value to minimise; it may stop early and return any partial value
/// greater than `limit` (the particle's own best) once it is sure to exceed it – exact, because a fitness is only ever
/// compared with the particle's own best. Called from several threads, of one particle by one at a time and in the
/// order of its iterations.
using Fitness = std::function<Result<double>(std::size_t particle, const std::vector<double>& position, double limit)>;

/// Minimises over the box. A fitness that is infinite or NaN never becomes a best. Particles are evaluated in parallel
/// and compared only after all of an iteration are known, and every random number is drawn by the calling thread in a
/// fixed order, so the result does not depend on the number of threads. `progress` is called by the calling thread
/// alone, after each of its evaluations and after each iteration. Fails with usage on bad options, interrupted if
/// `progress` says so, or with the first (lowest particle index) fault of a fitness.
[[nodiscard]] Result<SwarmSummary> minimise(const Fitness& fitness, const SwarmBox& box, const SwarmOptions& options,
                                            const ProgressSink& progress = {});

/// Eq. 10: ω_max − (ω_max − ω_min) t/T_max. t = 0 is the initial swarm; its first move has t = 1, its last t = T_max.
[[nodiscard]] double inertia_weight(const SwarmOptions& options, int t);

/// One coordinate of one particle.
struct Coordinate {
  double position{};
  double velocity{};
};

/// The move of a coordinate with the velocity eq. 9 gave it: velocity limited to ±`v_max` first, then the move, then
/// the position clamped to the box, which sets the velocity to 0.
[[nodiscard]] Coordinate moved(Coordinate from, double v_max, double lower, double upper);

}  // namespace gyrotherm::svm
