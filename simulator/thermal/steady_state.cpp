// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/steady_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/brick_solver.hpp"
#include "simulator/thermal/hex20.hpp"

namespace gyrotherm::thermal {
namespace {

void mark_extremes(const GyroMesh& mesh, SteadyState& state) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (auto* point : {&state.hottest, &state.block_hottest}) point->temperature_c = -kInfinity;
  for (auto* point : {&state.coldest, &state.block_coldest}) point->temperature_c = kInfinity;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass& brick) {
    if (brick.shares.empty()) return;
    const auto part = main_part(brick);
    if (is_gas(part) || is_air(part)) return;
    const auto nodes = brick_nodes(mesh, i, j, k);
    for (int n = 0; n < kHex20; ++n) {
      const auto& position = kHex20Positions[n];
      const double t = state.field_c[nodes[n]];
      const auto point = [&] {
        return ExtremePoint{
            t,
            {doubled_coordinate(mesh.x, 2 * i + position[0]), doubled_coordinate(mesh.y, 2 * j + position[1]),
             doubled_coordinate(mesh.z, 2 * k + position[2])},
            part};
      };
      if (t > state.hottest.temperature_c) state.hottest = point();
      if (t < state.coldest.temperature_c) state.coldest = point();
      if (part != GyroPart::block) continue;
      if (t > state.block_hottest.temperature_c) state.block_hottest = point();
      if (t < state.block_coldest.temperature_c) state.block_coldest = point();
    }
  });
}

/// One steady problem. Members that do not change between the rounds are computed once.
class SteadySolver {
 public:
  SteadySolver(const GyroModel& model, const GyroMesh& mesh, const SteadyOptions& options)
      : model_(model),
        mesh_(mesh),
        options_(options),
        film_(options.film_w_per_m2_k.value_or(model.mode == GyroMode::full ? model.still_film_w_per_m2_k
                                                                            : model.block_film_w_per_m2_k)),
        outputs_(assemble_outputs(model, mesh)) {
    const auto inputs = assemble_inputs(mesh);
    power_ = Eigen::VectorXd::Zero(inputs.rows());
    for (std::size_t p = 0; p < model.powers_w.size(); ++p)
      power_ += model.powers_w[p] * inputs.col(static_cast<Eigen::Index>(p) + 1);
    rise_ = Eigen::VectorXd::Zero(inputs.rows());
  }

  Result<SteadyState> run() {
    // Initial estimate: typical rise of the air temperature in a working gyro, K.
    constexpr double kUsualRise = 6;
    const bool linear = options_.coefficients.has_value() || model_.mode == GyroMode::block;
    state_.unknowns = mesh_.node_count;
    state_.air_c = options_.ambient_c + kUsualRise;
    for (state_.rounds = 1; state_.rounds <= options_.most_rounds; ++state_.rounds) {
      state_.coefficients = options_.coefficients.value_or(coefficients_at(model_.air, state_.air_c, film_));
      if (const auto solved = solve(); !solved) return failure(solved.error());
      const double found_c = air_temperature_c(state_.outputs_c);
      if (linear) state_.air_c = found_c;
      if (linear || std::abs(found_c - state_.air_c) <= options_.tolerance_k) return make_result();
      state_.air_c = next_air_c(found_c);
    }
    return failure(FaultKind::numeric, "steady state",
                   fmt::format("the air's temperature did not settle within {} K in {} rounds", options_.tolerance_k,
                               options_.most_rounds));
  }

 private:
  /// Returns the air temperature for the next round: the temperature that this round has found, or from the second
  /// round on the extrapolation of the last two rounds (Steffensen's method for a fixed point).
  double next_air_c(double found_c) {
    double next_c = found_c;
    if (last_) {
      const double slope = (found_c - last_->found_c) / (state_.air_c - last_->taken_c);
      if (std::abs(slope) < 0.5) next_c = state_.air_c + (found_c - state_.air_c) / (1 - slope);
    }
    last_ = Round{state_.air_c, found_c};
    return next_c;
  }

  /// Solves for the rise over the ambient. Its right-hand side contains only the powers.
  Result<void> solve() {
    if (solver_) {
      solver_->replace(model_, mesh_, state_.coefficients);
    } else {
      auto made = BrickSolver::create(model_, mesh_, state_.coefficients);
      if (!made) return failure(made.error());
      solver_ = std::move(*made);
    }
    auto solution = solver_->solve(power_, rise_);
    if (!solution) return failure(solution.error());
    rise_ = std::move(solution->x);
    state_.iterations += solution->iterations;
    const Eigen::VectorXd y = outputs_ * rise_;
    for (std::size_t o = 0; o < kThermalOutputs; ++o)
      state_.outputs_c[o] = options_.ambient_c + y[static_cast<Eigen::Index>(o)];
    return {};
  }

  SteadyState make_result() {
    const double film = state_.coefficients[static_cast<std::size_t>(ThermalCoefficient::film)];
    state_.power_in_w = power_.sum();
    state_.power_out_w = film * assemble_film_ambient(mesh_).dot(rise_);
    state_.field_c = rise_.array() + options_.ambient_c;
    mark_extremes(mesh_, state_);
    return std::move(state_);
  }

  const GyroModel& model_;
  const GyroMesh& mesh_;
  const SteadyOptions& options_;
  double film_;
  SparseMatrix outputs_;
  Eigen::VectorXd power_;
  Eigen::VectorXd rise_;
  struct Round {
    double taken_c, found_c;
  };
  std::optional<Round> last_;
  std::optional<BrickSolver> solver_;
  SteadyState state_;
};

}  // namespace

Result<SteadyState> steady_state(const GyroModel& model, const GyroMesh& mesh, const SteadyOptions& options) {
  return SteadySolver(model, mesh, options).run();
}

double gain_difference_k(std::span<const double, kThermalOutputs> outputs_c) {
  const auto& y = outputs_c;
  return (y[0] + y[1] + y[2]) / 3 - (y[5] + y[6] + y[7]) / 3;
}

double air_temperature_c(std::span<const double, kThermalOutputs> outputs_c) {
  return (outputs_c[static_cast<std::size_t>(ThermalOutput::block)] +
          outputs_c[static_cast<std::size_t>(ThermalOutput::shell)]) /
         2;
}

}  // namespace gyrotherm::thermal
