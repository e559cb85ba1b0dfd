// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/reduced/reduced_model.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

void expect_same(const ReducedModel& a, const ReducedModel& b) {
  EXPECT_EQ(a.gyro, b.gyro);
  EXPECT_EQ(a.source_sha256, b.source_sha256);
  EXPECT_EQ(a.mesh, b.mesh);
  EXPECT_EQ(a.powers_w, b.powers_w);
  EXPECT_EQ(a.air.lid.nusselt, b.air.lid.nusselt);
  EXPECT_EQ(a.air.side.width_m, b.air.side.width_m);
  EXPECT_EQ(a.air.base.emissivity, b.air.base.emissivity);
  EXPECT_EQ(a.still_film_w_per_m2_k, b.still_film_w_per_m2_k);
  EXPECT_EQ(a.chamber_film_w_per_m2_k, b.chamber_film_w_per_m2_k);
  EXPECT_EQ(a.error.transfer_k, b.error.transfer_k);
  EXPECT_EQ(a.error.ramp_k, b.error.ramp_k);
  EXPECT_EQ(a.error.switch_on_k, b.error.switch_on_k);
  EXPECT_TRUE(same_bits(a.conduction, b.conduction));
  for (std::size_t m = 0; m < kThermalCoefficients; ++m)
    EXPECT_TRUE(same_bits(a.conduction_per[m], b.conduction_per[m]));
  EXPECT_TRUE(same_bits(a.inputs, b.inputs));
  EXPECT_TRUE(same_bits(a.film_ambient, b.film_ambient));
  EXPECT_TRUE(same_bits(a.outputs, b.outputs));
}

/// Returns the text with the first occurrence of `from` replaced. Requires that there is one.
std::string with(std::string text, std::string_view from, std::string_view to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_error(const std::string& text, std::string_view what) {
  const auto model = parse_reduced_model(text, "gyro.reduced.toml");
  ASSERT_FALSE(model) << what;
  EXPECT_EQ(model.error().kind, FaultKind::bad_file);
  EXPECT_TRUE(model.error().where.starts_with("gyro.reduced.toml:")) << model.error().where;
  EXPECT_NE(model.error().what.find(what), std::string::npos) << model.error().what;
}

TEST(ReducedModel, RoundTripsBitForBit) {
  auto model = reduced_box_gyro();
  model.gyro = "a \"quoted\" \\ name\n°C";
  model.error = {1.0 / 3, 2e-5, 7};
  const auto back = parse_reduced_model(reduced_model_text(model), "x.toml");
  ASSERT_TRUE(back) << text(back.error());
  expect_same(model, *back);
}

TEST(ReducedModel, RoundTripsNumbersOfAnySizeBitForBit) {
  constexpr unsigned kSeed = 20151130;
  SCOPED_TRACE(fmt::format("seed {}", kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> exponent(-300, 300);
  auto model = reduced_box_gyro();
  // There is no power, so only the first column of B₀ matters. It belongs to the ambient.
  model.powers_w = {};
  for (Eigen::Index i = 0; i < model.inputs.rows(); ++i)
    for (Eigen::Index j = 1; j < model.inputs.cols(); ++j)
      model.inputs(i, j) = std::pow(10, exponent(random)) * (random() % 2 == 0 ? 1 : -1);
  model.inputs(0, 1) = -0.0;
  model.inputs(1, 1) = 5e-324;
  model.inputs(2, 1) = 1e22;
  model.inputs(3, 1) = -20;
  const auto back = parse_reduced_model(reduced_model_text(model), "x.toml");
  ASSERT_TRUE(back) << text(back.error());
  expect_same(model, *back);
}

TEST(ReducedModel, ReportsEachErrorWithPosition) {
  const auto good = reduced_model_text(reduced_box_gyro());
  expect_error(with(good, "gyro/1", "gyro/9"), "is not understood");
  expect_error(with(good, "source_sha256 = \"0", "source_sha256 = \"X"), "64 lower-case hexadecimal digits");
  expect_error(with(good, "still_film_w_per_m2_k = 8.0", "still_film_w_per_m2_k = 0.0"), "above 0");
  expect_error(with(good, "emissivity = 0.05", "emissivity = -1.0"), "at least 0");
  expect_error(with(good, "preamplifier = 0.784", "preamplifier = -0.784"), "at least 0");
  expect_error(with(good, "width_m = 0.018\n", ""), "missing key \"width_m\"");
  expect_error(with(good, "gain_left = 0.294", "gain_lift = 0.294"), "did you mean");
  expect_error(with(good, "film_ambient = [", "film_ambient = [0.0, "), "numbers, expected");
  expect_error(with(good, "air_lid = [\n[", "air_lid = [\n[0.0, "), "row 1 has 2 numbers, expected 1");
  expect_error(with(good, "states = ", "states = 100"), "expected 1 … 200");
  expect_error(with(good, "states = ", "states = 0.5 # "), "expected a whole number");
  expect_error("states = 1", "missing key \"schema\"");
}

TEST(ReducedModel, RefusesUnstableBody) {
  auto model = reduced_box_gyro();
  model.conduction *= -1;
  expect_error(reduced_model_text(model), "not positive definite");
}

TEST(ReducedModel, RefusesBodyThatDoesNotRestAtAmbient) {
  auto model = reduced_box_gyro();
  model.film_ambient *= 1.001;
  expect_error(reduced_model_text(model), "without power the steady outputs");
}

TEST(ReducedModel, RestsAtAmbientWithoutPower) {
  const auto& model = reduced_box_gyro();
  for (const double air_c : {-60.0, 20.0, 80.0}) {
    const auto c = coefficients_at(model, air_c, GyroFilm::chamber);
    const Eigen::VectorXd rest = model.outputs * states_at(model, c, 0).col(0);
    EXPECT_LE((rest.array() - 1).abs().maxCoeff(), 1e-10);
  }
}

}  // namespace
}  // namespace gyrotherm::thermal
