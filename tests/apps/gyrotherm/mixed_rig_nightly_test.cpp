// SPDX-License-Identifier: Apache-2.0
/// The whole experiment with other instruments gives the same analysis. Takes minutes.
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

TEST(MixedRig, GivesSameAnalysisWithinNoise) {
  const Folder folder;
  const auto one = report_on("virtual", folder / "default");
  const auto other = report_on("virtual-mixed", folder / "mixed");
  EXPECT_EQ(other["clusters"], one["clusters"]);
  EXPECT_EQ(other["selected_pairs"], one["selected_pairs"]);
  for (const auto* run : {"rate", "random"}) {
    // The read-outs differ by the gyro's clock, by a constant 5e-5 °/h.
    EXPECT_NEAR(figure(other, run, "raw"), figure(one, run, "raw"), 1e-5) << run;
    // Readings that differ by half a millikelvin change the result of a small swarm.
    for (const auto* model : {"three_point", "multi_point", "multi_point_t"}) {
      const double was = figure(one, run, model), is = figure(other, run, model);
      EXPECT_NEAR(is, was, 0.05 * was) << run << " " << model;
    }
  }
  EXPECT_NEAR(other["noise_floor_deg_per_h"].get<double>(), one["noise_floor_deg_per_h"].get<double>(), 5e-5);
}

}  // namespace
}  // namespace gyrotherm::app
