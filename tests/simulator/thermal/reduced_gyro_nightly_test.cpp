// SPDX-License-Identifier: Apache-2.0
/// Compares the reduced model with the finite elements over time and over the coefficients. Takes minutes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/model_order_reduction.hpp"
#include "simulator/thermal/model_order_reduction_error.hpp"
#include "simulator/thermal/reduced/reduced_model.hpp"
#include "simulator/thermal/reduced/reduced_transient.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {
namespace {

const std::string kGyros = GYROTHERM_SOURCE_DIR "/profiles/gyros/";

GyroModel gyro_of(const std::string& name) {
  const auto text = read_text_file(kGyros + name + ".toml");
  const auto gyro = parse_gyro(text ? *text : "", name);
  EXPECT_TRUE(gyro);
  return gyro ? *gyro : GyroModel{};
}

/// Full and reduced model of the calibrated gyro on the coarse mesh.
struct Coarse {
  ThermalSystem system;
  ReducedSystem reduced;
};

const Coarse& coarse() {
  static const Coarse made = [] {
    const auto gyro = gyro_of("calibrated");
    Coarse c{assemble(gyro, make_mesh(gyro, MeshSize::coarse)), {}};
    auto reduced = reduce(c.system, make_header(gyro, std::string(64, '0')), {}, multigrid_solver());
    EXPECT_TRUE(reduced) << text(reduced.error());
    if (reduced) c.reduced = std::move(*reduced);
    return c;
  }();
  return made;
}

TEST(ReducedGyro, FollowsLinearModelInTime) {
  for (const double air_c : {-40.0, 20.0, 60.0}) {
    const auto error = measure(coarse().system, coarse().reduced, {.air_c = air_c}, multigrid_solver());
    ASSERT_TRUE(error) << text(error.error());
    fmt::print("coefficients of {:3} °C: ramps {:.2e} K, switch-on {:.2e} K\n", air_c, error->ramp_k,
               error->switch_on_k);
    EXPECT_LE(error->ramp_k, 1e-3) << air_c;
    EXPECT_LE(error->switch_on_k, 1e-2) << air_c;
  }
}

/// Returns the air temperature: +5 °C/min from 20 to 60 °C, a hold of 30 min, −5 °C/min to −40 °C, a hold of 20 min,
/// and +1 °C/min to −10 °C.
double program_c(double t_s) {
  if (t_s < 480) return 20 + t_s / 12;
  if (t_s < 2280) return 60;
  if (t_s < 3480) return 60 - (t_s - 2280) / 12;
  if (t_s < 4680) return -40;
  return -40 + (t_s - 4680) / 60;
}
constexpr int kProgram_s = 6480;

/// Returns the steady state of the full model with air coefficients at its temperature. The iteration starts from the
/// steady state of the twin.
Eigen::VectorXd full_rest(const ThermalSystem& system, const ReducedModel& model, double air_c) {
  AffineMatrix matrices(system);
  const Eigen::VectorXd load = system.inputs * operating_inputs(model, 0);
  double gap_c = gap_air_c(model.outputs * states_at_rest(model, GyroFilm::chamber, air_c));
  Eigen::VectorXd above = Eigen::VectorXd::Zero(load.size());
  for (int round = 0; round < 5; ++round) {
    const auto& matrix = matrices.sum(0, 1, coefficients_at(model, gap_c, GyroFilm::chamber));
    const auto missing = multigrid_solver()(matrix, load - matrix * above);
    EXPECT_TRUE(missing);
    above += missing->col(0);
    gap_c = gap_air_c((system.outputs * above).array() + air_c);
  }
  return above.array() + air_c;
}

/// Returns the largest difference between twin and full model over A … H. The full model updates its coefficients every
/// 10 s.
double largest_difference(const ThermalSystem& system, const ReducedModel& model, int step_s) {
  constexpr int kUpdate_s = 10;
  FullTransient full(system, full_rest(system, model, program_c(0)), 1e-7);
  ReducedTransient reduced(model, {.start = {program_c(0)}, .seconds_per_update = kUpdate_s});
  double largest_k = 0;
  for (int t = 0; t < kProgram_s; t += step_s) {
    if (t % kUpdate_s == 0) {
      EXPECT_TRUE(full.set(step_s, coefficients_at(model, gap_air_c(full.outputs_c()), GyroFilm::chamber)));
    }
    EXPECT_TRUE(full.step(operating_inputs(model, program_c(t)), operating_inputs(model, program_c(t + step_s))));
    for (int s = 1; s <= step_s; ++s) reduced.step({program_c(t + s)});
    const Eigen::VectorXd truth = full.outputs_c();
    for (std::size_t i = 0; i < 8; ++i)
      largest_k = std::max(largest_k, std::abs(truth[static_cast<Eigen::Index>(i)] - reduced.outputs_c()[i]));
  }
  return largest_k;
}

TEST(ReducedGyro, FollowsNonlinearModelThroughRampsAsTwin) {
  const double error_k = largest_difference(coarse().system, coarse().reduced.model, 10);
  fmt::print("twin against the full model, both with air that follows its temperature: {:.2e} K\n", error_k);
  EXPECT_LE(error_k, 5e-3);
}

TEST(ReducedGyro, MatchesFullModelWhenDrawn) {
  const auto& type = coarse().reduced.model;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    RandomStream random(seed, RandomPurpose::film_spread);
    const auto drawn = perturb_model(type, {.gap = 0.1, .film = 0.2, .power = 0.05, .arms = 0.1}, random);
    // The capacity has no spread, so the ratios of the matrices are the factors of the gaps.
    auto c = coefficients_at(drawn, 10, GyroFilm::chamber);
    const auto drawn_c = c;
    for (std::size_t m = 0; m < 3; ++m) c[m] *= drawn.conduction_per[m].norm() / type.conduction_per[m].norm();
    AffineMatrix matrices(coarse().system);
    const auto above = multigrid_solver()(matrices.sum(0, 1, c), coarse().system.inputs * operating_inputs(drawn, 0));
    ASSERT_TRUE(above);
    const Eigen::VectorXd miss = coarse().system.outputs * above->col(0) -
                                 drawn.outputs * (states_at(drawn, drawn_c, 0) * operating_inputs(drawn, 0));
    EXPECT_LE(miss.cwiseAbs().maxCoeff(), 5e-3);
  }
}

TEST(ReducedGyro, MatchesShippedFile) {
  for (const std::string name : {"calibrated", "fast-film"}) {
    const auto source = read_text_file(kGyros + name + ".toml");
    const auto file = read_text_file(kGyros + name + ".reduced.toml");
    ASSERT_TRUE(source && file);
    const auto shipped = parse_reduced_model(*file, name);
    ASSERT_TRUE(shipped) << text(shipped.error());
    const auto gyro = gyro_of(name);
    const auto system = assemble(gyro, make_mesh(gyro, MeshSize::medium));
    const auto made = reduce(system, make_header(gyro, sha256(*source)), {}, multigrid_solver());
    ASSERT_TRUE(made) << text(made.error());
    EXPECT_EQ(shipped->source_sha256, made->model.source_sha256);
    // The basis may depend on the machine, but the responses must not.
    for (const double air_c : {-60.0, -10.0, 40.0, 80.0}) {
      for (const double s : {0.0, 3e-4, 3e-3}) {
        const auto c = coefficients_at(*shipped, air_c, GyroFilm::chamber);
        const Eigen::MatrixXd miss =
            made->model.outputs * states_at(made->model, c, s) - shipped->outputs * states_at(*shipped, c, s);
        EXPECT_LE((miss * reference_loads(*shipped)).cwiseAbs().maxCoeff(), 2e-3) << name << air_c << s;
      }
    }
  }
}

}  // namespace
}  // namespace gyrotherm::thermal
