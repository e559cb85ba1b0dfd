// SPDX-License-Identifier: Apache-2.0
/// Tests profiles/gyros/*.reduced.toml and the gyro files from which they are made.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/reduced/reduced_transient.hpp"

namespace gyrotherm::thermal {
namespace {

/// Returns the names of the gyros that have a reduced model, at least two.
std::vector<std::string> gyro_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/gyros")) {
    const auto name = entry.path().filename().string();
    constexpr std::string_view kSuffix = ".reduced.toml";
    if (name.ends_with(kSuffix)) names.push_back(name.substr(0, name.size() - kSuffix.size()));
  }
  EXPECT_GE(names.size(), 2u);
  return names;
}

std::string text_of(const std::string& name) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/" + name);
  EXPECT_TRUE(text) << name;
  return text ? *text : "";
}

TEST(ShippedGyros, DefaultRigHasReducedModel) {
  const auto names = gyro_names();
  EXPECT_NE(std::ranges::find(names, "calibrated"), names.end());
}

TEST(ShippedGyros, ReducedModelsMatchHashOfGyroFiles) {
  for (const auto& name : gyro_names()) {
    const auto source = text_of(name + ".toml");
    const auto gyro = parse_gyro(source, name + ".toml");
    const auto model = parse_reduced_model(text_of(name + ".reduced.toml"), name + ".reduced.toml");
    ASSERT_TRUE(gyro) << text(gyro.error());
    ASSERT_TRUE(model) << text(model.error());
    EXPECT_EQ(model->source_sha256, sha256(source)) << name << ": run gyrotherm-thermal reduce";
    EXPECT_EQ(model->gyro, gyro->name);
    EXPECT_EQ(model->powers_w, gyro->powers_w);
    EXPECT_EQ(model->chamber_film_w_per_m2_k, gyro->chamber_film_w_per_m2_k);
  }
}

TEST(ShippedGyros, ReducedModelsMeetTheirGoals) {
  for (const auto& name : gyro_names()) {
    const auto text = text_of(name + ".reduced.toml");
    const auto model = parse_reduced_model(text, name);
    ASSERT_TRUE(model);
    EXPECT_LE(model->conduction.rows(), 84) << name;
    EXPECT_LE(model->error.transfer_k, 5e-3) << name;
    EXPECT_GT(model->error.ramp_k, 0) << name << ": not measured";
    EXPECT_LE(model->error.ramp_k, 1e-3) << name;
    EXPECT_LE(model->error.switch_on_k, 1e-2) << name;
    EXPECT_LT(text.size(), 500'000U) << name;
  }
}

TEST(ShippedGyros, ReducedModelsAreSymmetric) {
  for (const auto& name : gyro_names()) {
    const auto model = parse_reduced_model(text_of(name + ".reduced.toml"), name);
    ASSERT_TRUE(model);
    const Eigen::VectorXd rest = model->outputs * states_at_rest(*model, GyroFilm::still, 20);
    constexpr Eigen::Index kPairs[][2] = {{1, 2}, {3, 4}, {5, 7}, {9, 10}, {13, 14}, {15, 16}};
    for (const auto& [left, right] : kPairs) EXPECT_NEAR(rest[left], rest[right], 2e-3) << name;
  }
}

}  // namespace
}  // namespace gyrotherm::thermal
