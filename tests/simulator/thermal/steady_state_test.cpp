// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/steady_state.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/difference_fit.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr double kRough = 9.0;  // mm; about 24,000 nodes

double at(const SteadyState& state, ThermalOutput output) { return state.outputs_c[static_cast<std::size_t>(output)]; }

class Steady : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    model_ = new GyroModel(shipped_gyro("calibrated"));
    mesh_ = new GyroMesh(make_mesh(*model_, kRough));
    const auto state = steady_state(*model_, *mesh_);
    ASSERT_TRUE(state) << text(state.error());
    state_ = new SteadyState(*state);
  }
  static void TearDownTestSuite() {
    delete state_;
    delete mesh_;
    delete model_;
  }
  void SetUp() override { ASSERT_NE(state_, nullptr) << "no steady state"; }

  static inline GyroModel* model_ = nullptr;
  static inline GyroMesh* mesh_ = nullptr;
  static inline SteadyState* state_ = nullptr;
};

TEST_F(Steady, BalancesPower) {
  EXPECT_NEAR(state_->power_in_w, 0.588 + 0.784 + 2 * 24.41e4 * 295e-9, 1e-12);
  EXPECT_NEAR(state_->power_out_w, state_->power_in_w, 1e-6);
}

TEST_F(Steady, IsSymmetric) {
  using enum ThermalOutput;
  for (const auto& [left, right] :
       {std::pair{b, c}, {d, e}, {f, h}, {gain_left, gain_right}, {mirror_b, mirror_c}, {mirror_f, mirror_h}})
    EXPECT_NEAR(at(*state_, left), at(*state_, right), 1e-6);
}

TEST_F(Steady, HasHotGainSideAndColdestG) {
  for (std::size_t t = 0; t < 8; ++t) EXPECT_GE(state_->outputs_c[t], at(*state_, ThermalOutput::g));
  EXPECT_GT(gain_difference_k(state_->outputs_c), 3);
  EXPECT_EQ(state_->coldest.part, GyroPart::shell);
  EXPECT_GT(state_->block_hottest.at_m[1], 0.1) << "the hottest point is next to a gain bore";
  EXPECT_LT(state_->block_coldest.at_m[1], 0.03);
}

TEST_F(Steady, AirConductsAtItsTemperature) {
  EXPECT_NEAR(air_temperature_c(state_->outputs_c), state_->air_c, 1e-4);
  const auto expected =
      coefficients_at(model_->air, air_temperature_c(state_->outputs_c), model_->still_film_w_per_m2_k);
  for (std::size_t c = 0; c < kThermalCoefficients; ++c) EXPECT_NEAR(state_->coefficients[c] / expected[c], 1, 1e-6);
}

TEST_F(Steady, ImagesMatchThermometers) {
  const ThermalField field(*model_, *mesh_, state_->field_c);
  for (std::size_t t = 0; t < 8; ++t) {
    const auto& [u, v] = model_->thermometers[t];
    const double x = 0.075 + 1e-3 * u;
    const double y = 0.075 + 1e-3 * v;
    EXPECT_NEAR(field.temperature_at(x, y, 0.0525), state_->outputs_c[t], 1e-9);
    EXPECT_EQ(field.part_at(x, y, 0.0524), GyroPart::block);
  }
  EXPECT_EQ(field.part_at(0.075, 0.075, 0.04), GyroPart::hub);
  EXPECT_EQ(field.part_at(0.075, 0.075, 0.07), GyroPart::air_lid);
  EXPECT_EQ(field.part_at(0.045, 0.115, 0.04), GyroPart::gain_left);
  EXPECT_EQ(field.part_at(0.001, 0.075, 0.04), GyroPart::shell);
  EXPECT_FALSE(field.part_at(-0.001, 0.075, 0.04));
  EXPECT_TRUE(std::isnan(field.temperature_at(-0.001, 0.075, 0.04)));
}

TEST_F(Steady, ShiftsWithAmbientForFixedCoefficients) {
  SteadyOptions options;
  options.coefficients = state_->coefficients;
  options.ambient_c = -40;
  const auto cold = steady_state(*model_, *mesh_, options);
  ASSERT_TRUE(cold);
  EXPECT_EQ(cold->rounds, 1);
  for (std::size_t o = 0; o < kThermalOutputs; ++o) EXPECT_NEAR(cold->outputs_c[o] + 60, state_->outputs_c[o], 1e-6);
}

TEST_F(Steady, BlockRisesLessInHotAir) {
  SteadyOptions options;
  options.ambient_c = 60;
  const auto hot = steady_state(*model_, *mesh_, options);
  ASSERT_TRUE(hot);
  EXPECT_LT(at(*hot, ThermalOutput::block) - 60, at(*state_, ThermalOutput::block) - 20 - 0.5);
  EXPECT_LT(gain_difference_k(hot->outputs_c), gain_difference_k(state_->outputs_c));
}

TEST(BlockAlone, KeepsBalanceAndSymmetry) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  const auto state = steady_state(model, make_mesh(model, MeshSize::medium));
  ASSERT_TRUE(state) << text(state.error());
  EXPECT_NEAR(state->power_out_w, 0.588 + 2 * 24.41e4 * 295e-9, 1e-6);
  EXPECT_NEAR(at(*state, ThermalOutput::b), at(*state, ThermalOutput::c), 1e-6);
  EXPECT_EQ(at(*state, ThermalOutput::shell), 20);
}

/// Reference: body-fitted quadratic tetrahedra of the same block (601,341 nodes, passive bore filled with glass) give
/// 27.657, 28.057, 26.544, 24.402 and 23.668 °C at A, B, D, F and G, and a difference of 3.766 K. They come from
/// bench/thermal/tetrahedra.
TEST(BlockAlone, AgreesWithBodyFittedTetrahedra) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  model.materials[static_cast<std::size_t>(GyroMaterial::passive_bore)] = model.materials[0];
  const auto state = steady_state(model, make_mesh(model, MeshSize::medium));
  ASSERT_TRUE(state) << text(state.error());
  using enum ThermalOutput;
  for (const auto& [place, celsius] : {std::pair{a, 27.657}, {b, 28.057}, {d, 26.544}, {f, 24.402}, {g, 23.668}})
    EXPECT_NEAR(at(*state, place), celsius, 0.015);
  EXPECT_NEAR(gain_difference_k(state->outputs_c) / 3.766, 1, 0.005);
}

/// Repeats the comparison for a hole of 50 mm, with tetrahedra of 310,773 nodes.
TEST(BlockAlone, AgreesWithTetrahedraForSmallerHole) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  model.geometry.hole_diameter = 50;
  model.materials[static_cast<std::size_t>(GyroMaterial::passive_bore)] = model.materials[0];
  const auto state = steady_state(model, make_mesh(model, MeshSize::medium));
  ASSERT_TRUE(state) << text(state.error());
  using enum ThermalOutput;
  for (const auto& [place, celsius] : {std::pair{a, 27.077}, {b, 27.502}, {d, 26.150}, {f, 24.273}, {g, 23.645}})
    EXPECT_NEAR(at(*state, place), celsius, 0.015);
  EXPECT_NEAR(gain_difference_k(state->outputs_c) / 3.296, 1, 0.005);
}

TEST(DifferenceFit, FindsFilmForDifference) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  FitOptions options;
  options.edge_mm = kRough;
  const auto fit = fit_difference(model, FitParameter::film, 3.0, options);
  ASSERT_TRUE(fit) << text(fit.error());
  ASSERT_TRUE(fit->reached);
  const auto fitted = replace_parameter(model, FitParameter::film, fit->value);
  const auto state = steady_state(fitted, make_mesh(fitted, kRough));
  EXPECT_NEAR(gain_difference_k(state->outputs_c), 3.0, 0.002);
}

/// The film changes the difference by more than an order of magnitude, so plain secants move only one end.
TEST(DifferenceFit, NeedsFewStepsForAnyDifference) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  FitOptions options;
  options.edge_mm = kRough;
  for (const double wanted_k : {1.5, 3.0, 4.0}) {
    for (const FitParameter parameter : {FitParameter::film, FitParameter::thickness}) {
      const auto fit = fit_difference(model, parameter, wanted_k, options);
      ASSERT_TRUE(fit) << text(fit.error());
      EXPECT_LE(fit->steps, 8) << wanted_k;
    }
  }
}

TEST(DifferenceFit, ReportsUnreachableDifference) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  FitOptions options;
  options.edge_mm = kRough;
  const auto fit = fit_difference(model, FitParameter::film, 50, options);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->reached);
  EXPECT_EQ(fit->value, fit_range(model, FitParameter::film).low);
}

TEST(DifferenceFit, StopsWhenInterrupted) {
  const auto model = shipped_gyro("calibrated");
  const auto fit = fit_difference(model, FitParameter::film, 3, {}, [](auto, double) { return false; });
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().kind, FaultKind::interrupted);
}

TEST(DifferenceFit, SearchesThicknessesThatLeaveSpaceForPreamplifier) {
  GyroModel model = shipped_gyro("calibrated");
  auto& g = model.geometry;
  g.cabinet[2] = 60;
  const double inside = 60 - 2 * g.wall;
  g.preamplifier[2] = 12;
  const auto high = [&](GyroMode mode, PreamplifierMount mount) {
    model.mode = mode;
    g.preamplifier_mount = mount;
    const FitRange range = fit_range(model, FitParameter::thickness);
    EXPECT_EQ(range.low, std::max({g.mirror_height, g.cathode[2], 15.0}));
    return range.high;
  };
  EXPECT_EQ(high(GyroMode::full, PreamplifierMount::wall), inside - 10);
  EXPECT_EQ(high(GyroMode::full, PreamplifierMount::lid), inside - 24);
  EXPECT_EQ(high(GyroMode::full, PreamplifierMount::base), inside - 24);
  EXPECT_EQ(high(GyroMode::block, PreamplifierMount::lid), inside - 10) << "a block alone has no preamplifier";
  g.preamplifier[2] = 3;
  EXPECT_EQ(high(GyroMode::full, PreamplifierMount::lid), inside - 10);
}

TEST(DifferenceFit, SearchesOnlyPresentThicknessWhenNoOtherIsPossible) {
  GyroModel model = shipped_gyro("calibrated");
  model.geometry.cabinet[2] = 38;
  model.geometry.block_thickness = 24;
  const FitRange range = fit_range(model, FitParameter::thickness);
  EXPECT_EQ(range.low, 24);
  EXPECT_EQ(range.high, 24);
  model.mode = GyroMode::block;
  FitOptions options;
  options.edge_mm = kRough;
  const auto fit = fit_difference(model, FitParameter::thickness, 50, options);
  ASSERT_TRUE(fit) << text(fit.error());
  EXPECT_FALSE(fit->reached);
  EXPECT_EQ(fit->value, 24);
}

TEST(DifferenceFit, ChangesGapsWithThickness) {
  const auto thick = replace_parameter(shipped_gyro("calibrated"), FitParameter::thickness, 35);
  EXPECT_NEAR(thick.air.lid.width_m, 0.0195, 1e-12);
}

}  // namespace
}  // namespace gyrotherm::thermal
