// SPDX-License-Identifier: Apache-2.0
/// The whole experiment behind other instruments leads to the same analysis: minutes, not seconds.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

nlohmann::json report_on(const std::string& rig, const std::string& out) {
  const auto ran = gyrotherm_with("qualify --quick --seed 1 --rig profiles/rigs/" + rig + ".toml --out " + out);
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  return nlohmann::json::parse(read_text_file(out + "/report/report.json", kLargestTable).value());
}

double figure(const nlohmann::json& report, const char* run, const char* model) {
  return report[run][model]["std_deg_per_h"].get<double>();
}

TEST(MixedRig, TheWholeExperimentGivesTheSameAnalysisWithinNoise) {
  const Folder folder;
  const auto one = report_on("virtual", folder / "default");
  const auto other = report_on("virtual-mixed", folder / "mixed");
  EXPECT_EQ(other["clusters"], one["clusters"]);
  EXPECT_EQ(other["selected_pairs"], one["selected_pairs"]);
  for (const auto* run : {"rate", "random"}) {
    // The read-outs differ by the gyro's clock: 5e-5 °/h, but constant.
    EXPECT_NEAR(figure(other, run, "raw"), figure(one, run, "raw"), 1e-5) << run;
    // What a tuning by a small swarm may make of readings that differ by half a millikelvin.
    for (const auto* model : {"three_point", "multi_point", "multi_point_t"}) {
      const double was = figure(one, run, model), is = figure(other, run, model);
      EXPECT_NEAR(is, was, 0.05 * was) << run << " " << model;
    }
  }
  EXPECT_NEAR(other["noise_floor_deg_per_h"].get<double>(), one["noise_floor_deg_per_h"].get<double>(), 5e-5);
}

}  // namespace
}  // namespace gyrotherm::app
