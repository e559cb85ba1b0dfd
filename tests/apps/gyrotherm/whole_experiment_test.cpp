// SPDX-License-Identifier: Apache-2.0
/// The experiment at full length with the full swarm. Takes minutes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

nlohmann::json read_report(const std::string& folder) {
  return nlohmann::json::parse(read_text_file(folder + "/report/report.json", kLargestTable).value());
}

double residual_std(const nlohmann::json& report, const char* run, const char* model) {
  return report[run][model]["std_deg_per_h"].get<double>();
}

TEST(WholeExperiment, OneSeedGivesOneReport) {
  const Folder folder;
  for (const auto* out : {"a", "b"}) ASSERT_EQ(gyrotherm_with("qualify --out " + (folder / out)).exit_code, 0);
  EXPECT_EQ(read_text_file(folder / "a/report/report.json", kLargestTable).value(),
            read_text_file(folder / "b/report/report.json", kLargestTable).value());
  const auto report = read_report(folder / "a");
  EXPECT_EQ(report["clusters"]["rate"], 2216);
  EXPECT_EQ(report["clusters"]["random"], 1440);
}

TEST(WholeExperiment, ApproachesNoiseFloorWithTemperature) {
  const Folder folder;
  ASSERT_EQ(
      gyrotherm_with("qualify --rig profiles/rigs/virtual-reference.toml --seed 1 --out " + (folder / "out")).exit_code,
      0);
  const auto report = read_report(folder / "out");
  EXPECT_LT(residual_std(report, "random", "multi_point_t"), 1.5 * report["noise_floor_deg_per_h"].get<double>());
  EXPECT_LT(residual_std(report, "random", "multi_point_t"), residual_std(report, "random", "three_point"));
}

TEST(WholeExperiment, PublishedInputsSufficeForGradientGyro) {
  const Folder folder;
  ASSERT_EQ(gyrotherm_with("qualify --rig profiles/rigs/virtual-gradients.toml --out " + (folder / "out")).exit_code,
            0);
  const auto report = read_report(folder / "out");
  EXPECT_LT(residual_std(report, "random", "multi_point"), 0.25 * residual_std(report, "random", "raw"));
}

}  // namespace
}  // namespace gyrotherm::app
