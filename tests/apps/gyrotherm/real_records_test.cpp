// SPDX-License-Identifier: Apache-2.0
/// Real recordings processed by the program. They are not part of the project: GYROTHERM_SHARED names their folder.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// Writes the shipped map with another gyro column.
void write_map(const std::string& path, const std::string& column) {
  auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/imports/freeimu.toml").value();
  std::ofstream(path) << std::regex_replace(text, std::regex("\"Gx\""), "\"" + column + "\"");
}

double linear_residual(const std::string& record, const std::string& inputs, const std::string& model) {
  const auto ran =
      gyrotherm_with("train " + record + " --method linear --inputs '" + inputs + "' --force --out " + model);
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  std::smatch match;
  EXPECT_TRUE(std::regex_search(ran.out, match, std::regex(R"(residual std \(n − p\): ([0-9.]+))"))) << ran.out;
  return match.empty() ? 0 : std::stod(match[1]);
}

TEST(FreeImu, ReproducesLinearResiduals) {
  if (shared_folder().empty()) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
  struct Reference {
    const char* column;
    double die, die_squared, both;
  };
  for (const auto& [column, die, die_squared, both] :
       {Reference{"Gx", 22.671, 13.329, 16.476}, {"Gy", 11.352, 10.300, 10.414}, {"Gz", 9.794, 10.046, 10.060}}) {
    const Folder folder;
    write_map(folder / "map.toml", column);
    const auto imported = gyrotherm_with("import " + shared_folder() + "/data/freeimu_Tempdata01-02-14.csv --map " +
                                         (folder / "map.toml") + " --out " + (folder / "r.db"));
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_NEAR(linear_residual(folder / "r.db", "die", folder / "m.json"), die, 6e-4) << column;
    EXPECT_NEAR(linear_residual(folder / "r.db", "die,die^2", folder / "m.json"), die_squared, 6e-4) << column;
    EXPECT_NEAR(linear_residual(folder / "r.db", "die,barometer", folder / "m.json"), both, 6e-4) << column;
  }
}

TEST(FreeImu, ReportsExtrapolationOfHonestSplit) {
  if (shared_folder().empty()) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
  const Folder folder;
  ASSERT_EQ(gyrotherm_with("import " + shared_folder() +
                           "/data/freeimu_Tempdata01-02-14.csv --map profiles/imports/freeimu.toml --out " +
                           (folder / "r.db"))
                .exit_code,
            0);
  ASSERT_EQ(gyrotherm_with("train " + (folder / "r.db") +
                           " --method linear --inputs die,die-barometer --clusters 0:14 --out " + (folder / "m.json"))
                .exit_code,
            0);
  const auto verified =
      gyrotherm_with("verify --json " + (folder / "m.json") + " " + (folder / "r.db") + " --clusters 14:21");
  ASSERT_EQ(verified.exit_code, 0) << verified.err;
  const auto figures = nlohmann::json::parse(verified.out);
  EXPECT_EQ(figures["compensated"]["count"], 7);
  EXPECT_GT(figures["outside_trained_range"], 0) << "one warm-up: the later part is warmer than the earlier";
}

}  // namespace
}  // namespace gyrotherm::app
