// SPDX-License-Identifier: Apache-2.0
/// The command `thermal`.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

std::string text_in(const std::string& path) { return read_text_file(path, kLargestTable).value_or(""); }

TEST(Thermal, WritesImageOfWorkingGyro) {
  const Folder folder;
  const auto ran = gyrotherm_with("thermal --mesh coarse --json --out " + (folder / "image"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  auto facts = nlohmann::json::parse(ran.out);
  EXPECT_EQ(facts["schema"], "gyrotherm-thermal/1");
  EXPECT_TRUE(facts["simulated"]);
  EXPECT_NEAR(facts["difference_k"].get<double>(), 3.5, 0.1) << "calibrated, on a coarse mesh";
  EXPECT_NEAR(facts["power_in_w"].get<double>(), facts["power_out_w"].get<double>(), 1e-6);
  const auto& t = facts["temperatures_c"];
  for (const char* place : {"A", "B", "C", "D", "E", "F", "H"}) EXPECT_GT(t[place], t["G"]) << "G is the coldest";
  EXPECT_GT(facts["wall_s"], 0);
  EXPECT_GT(facts["peak_memory_mb"], 0);
  facts.erase("wall_s");
  facts.erase("peak_memory_mb");
  EXPECT_EQ(facts, nlohmann::json::parse(text_in(folder / "image/thermal.json")));
  for (const char* view : {"top-face", "bores", "section"}) {
    const auto name = folder / (std::string("image/") + view);
    EXPECT_NE(text_in(name + ".svg").find("SIMULATED"), std::string::npos) << view;
    EXPECT_EQ(text_in(name + ".png").substr(1, 3), "PNG") << view;
  }
  EXPECT_EQ(text_in(folder / "image/gyro.vtu").rfind("<?xml", 0), 0U);
  EXPECT_NE(text_in(folder / "image/gyro.inp").find("*HEAT TRANSFER"), std::string::npos);
  const auto again = gyrotherm_with("thermal --mesh coarse --out " + (folder / "image"));
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("thermal.json: exists; --force overwrites it"), std::string::npos) << again.err;
}

TEST(Thermal, FigureHasValuesOfGyroFile) {
  const auto ran = shell(GYROTHERM_PROGRAM "-thermal figure");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto figure = nlohmann::json::parse(ran.out);
  EXPECT_EQ(figure["schema"], "gyrotherm-thermal-figure/1");
  EXPECT_TRUE(figure["simulated"]);
  // The values are those of profiles/gyros/calibrated.toml.
  const nlohmann::json zerodur{{"name", "zerodur"},
                               {"density_kg_per_m3", 2530.0},
                               {"specific_heat_j_per_kg_k", 800.0},
                               {"conductivity_w_per_m_k", 1.46}};
  EXPECT_EQ(figure["materials"].size(), 10U);
  EXPECT_EQ(figure["materials"][0], zerodur);
  EXPECT_EQ(figure["materials"][3]["density_kg_per_m3"], 3700) << "ballast";
  EXPECT_EQ(figure["materials"][4]["density_kg_per_m3"], 2140) << "preamplifier";
  EXPECT_TRUE(figure["materials"][9]["conductivity_w_per_m_k"].is_null()) << "air";
  const auto& sources = figure["sources"];
  ASSERT_EQ(sources.size(), 3U);
  const double expected[3][3] = {{0.588, 1.126e-6, 52.22e4}, {0.784, 35e-6, 2.24e4}, {0.0720095, 0.295e-6, 24.41e4}};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(sources[k]["power_w"].get<double>(), expected[k][0], 1e-9) << k;
    EXPECT_NEAR(sources[k]["volume_m3"].get<double>(), expected[k][1], 1e-12) << k;
    EXPECT_NEAR(sources[k]["rate_w_per_m3"].get<double>() / expected[k][2], 1, 1e-4) << k;
  }
  EXPECT_EQ(figure["image"]["mesh"], "coarse");
  EXPECT_NEAR(figure["image"]["difference_k"].get<double>(), 3.5, 0.1);
  EXPECT_EQ(figure["image"]["view"]["marks"].size(), 8U);
}

TEST(Thermal, PrintsSummaryWithHottestPoints) {
  const Folder folder;
  const auto ran = gyrotherm_with("thermal --mesh coarse --film 25 --ambient -40 --out " + (folder / "image"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  for (const char* word : {"SIMULATED", "hottest", "coldest", "rate x volume", "unknowns", "-40"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << word;
}

TEST(Thermal, RefusesUnusableInput) {
  const Folder folder;
  EXPECT_EQ(gyrotherm_with("thermal --mesh rough --out " + (folder / "a")).exit_code, 2);
  EXPECT_EQ(gyrotherm_with("thermal --film 0 --out " + (folder / "a")).exit_code, 2);
  const auto missing = gyrotherm_with("thermal --gyro nowhere.toml --out " + (folder / "a"));
  EXPECT_EQ(missing.exit_code, 4);
  EXPECT_TRUE(missing.err.starts_with("gyrotherm-thermal: nowhere.toml: ")) << missing.err;
  const auto rig = gyrotherm_with("thermal --gyro profiles/rigs/virtual.toml --out " + (folder / "a"));
  EXPECT_EQ(rig.exit_code, 4) << rig.err;
}

}  // namespace
}  // namespace gyrotherm::app
