// SPDX-License-Identifier: Apache-2.0
/// Particle swarm optimisation by eqs. 8–10 of the paper (order as in errata 2). The inertia weight falls linearly, and
/// the velocity is limited before each move. If a coordinate leaves the box, its position is clamped and its velocity
/// is set to 0.
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
  /// T_max of eq. 10. The initial swarm is evaluated before the first iteration.
  int iterations = 30;
  double omega_max = 0.9;  ///< eq. 10
  double omega_min = 0.4;  ///< eq. 10
  double c1 = 2.0;         ///< eq. 9
  double c2 = 2.0;         ///< eq. 9
  /// Velocity limit as a fraction of each coordinate's range.
  double v_max = 0.2;
  /// The swarm stops early after this many successive iterations without a total gain of more than `stall_gain`.
  int stall_iterations = 10;
  /// Relative improvement of the best fitness that restarts the count of iterations without a gain.
  double stall_gain = 1e-3;
  std::uint64_t seed = 1;
  /// Number of threads, 0 for all. The result does not depend on it.
  int threads = 0;
};

/// Returns the number of threads, at most the number that the machine provides. For a larger number oneTBB prints a
/// warning on stderr.
[[nodiscard]] int thread_count(const SwarmOptions& options);

/// Limits of each coordinate.
struct SwarmBox {
  std::vector<double> lower;  ///< per coordinate
  std::vector<double> upper;
};

enum class SwarmEnd { was_not_run, iterations_done, stalled };
inline constexpr std::initializer_list<SwarmEnd> kSwarmEnds = {SwarmEnd::was_not_run, SwarmEnd::iterations_done,
                                                               SwarmEnd::stalled};

/// Result of a swarm, and the reason for its end.
struct SwarmSummary {
  SwarmEnd end = SwarmEnd::was_not_run;
  std::vector<double> best;  ///< position
  double best_fitness{};     ///< lowest
  /// Best fitness after the initial swarm and after each iteration.
  std::vector<double> history;
  /// Coordinates of the best position on the edge of the box.
  std::vector<int> coordinates_on_edge;
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

/// Fitness to minimise: `fitness(particle, position, limit)`. Once the value is certain to exceed `limit`, the fitness
/// of the particle's best position so far, the function may return any number above `limit`. The swarm then proceeds
/// exactly as with the full value, because it only compares the value with `limit`. The function is called from several
/// threads. The calls for one particle come one at a time, in the order of the iterations.
using Fitness = std::function<Result<double>(std::size_t particle, const std::vector<double>& position, double limit)>;

/// Minimises the fitness over the box. A position with an infinite or NaN fitness never becomes a best position.
/// Particles are evaluated in parallel and compared only when all results of an iteration are available. The calling
/// thread draws all random numbers in a fixed order. The result therefore does not depend on the number of threads.
/// Only the calling thread calls `progress`, after each of its evaluations and after each iteration. Fails with usage
/// on bad options, with interrupted if `progress` requests a stop, or with the first fault of a fitness (lowest
/// particle index).
[[nodiscard]] Result<SwarmSummary> minimise(const Fitness& fitness, const SwarmBox& box, const SwarmOptions& options,
                                            const ProgressSink& progress = {});

/// Returns ω_max − (ω_max − ω_min) t/T_max (eq. 10). t = 0 is the initial swarm; its first move has t = 1, its last t =
/// T_max.
[[nodiscard]] double inertia_weight(const SwarmOptions& options, int t);

/// One coordinate of one particle.
struct Coordinate {
  double position{};
  double velocity{};
};

/// Moves a coordinate with the velocity from eq. 9. Limits the velocity to ±`v_max`, then moves, then clamps the
/// position to the box. Clamping sets the velocity to 0.
[[nodiscard]] Coordinate move_within_box(Coordinate from, double v_max, double lower, double upper);

}  // namespace gyrotherm::svm
