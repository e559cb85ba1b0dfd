// SPDX-License-Identifier: Apache-2.0
/// Output of `verify` in addition to its figures.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// Short record, and a linear model of its first cycle, which contains no rate of 5 °C/min.
class Verify : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    const auto recorded = gyrotherm_with("run tests/profiles/short-rate.toml --rig profiles/rigs/virtual.toml --out " +
                                         (*folder_ / "r.db"));
    ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
    const auto trained =
        gyrotherm_with("train " + (*folder_ / "r.db") + " --method linear --inputs seven-point --clusters 0:88 --out " +
                       (*folder_ / "m.json"));
    ASSERT_EQ(trained.exit_code, 0) << trained.err;
    ready_ = true;
  }
  static void TearDownTestSuite() { delete folder_; }
  static Ran verify(const std::string& options) {
    return gyrotherm_with("verify " + (*folder_ / "m.json") + " " + (*folder_ / "r.db") + " --clusters 88:160 " +
                          options);
  }
  static nlohmann::json verify_as_json(const std::string& options) {
    const auto ran = verify("--json " + options);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return nlohmann::json::parse(ran.out);
  }
  void SetUp() override { ASSERT_TRUE(ready_) << "the record or its model is missing"; }

  static inline Folder* folder_ = nullptr;
  /// A suite whose setup failed must fail, not be skipped.
  static inline bool ready_ = false;
};

TEST_F(Verify, AppliesPolicyForInputsOutsideTrainedRange) {
  const auto by_default = verify_as_json(""), continued = verify_as_json("--outside continue");
  const auto refused = verify_as_json("--outside refuse"), extrapolated = verify_as_json("--outside extrapolate");
  EXPECT_EQ(by_default, continued);
  EXPECT_EQ(continued["outside"]["policy"], "continue");
  const int outside = continued["outside_trained_range"];
  EXPECT_GT(outside, 0);
  EXPECT_EQ(refused["compensated"]["count"].get<int>(), continued["compensated"]["count"].get<int>() - outside);
  EXPECT_EQ(extrapolated["outside_trained_range"], outside);
  EXPECT_EQ(extrapolated["compensated"], continued["compensated"]) << "a plane continues unchanged";
}

TEST_F(Verify, ListsPoliciesWhenUnknown) {
  const auto ran = verify("--outside ignore");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("continue, refuse or extrapolate"), std::string::npos) << ran.err;
}

TEST_F(Verify, GivesNoiseAndErrorBars) {
  const auto report = verify_as_json("");
  const auto n = report["allan"]["coefficients"]["N"];
  EXPECT_NEAR(n["value"].get<double>(), 3e-4, 5 * n["error"].get<double>()) << "as in the model of the virtual gyro";
  EXPECT_GT(report["compensated"]["std_error_deg_per_h"], 0.0);
  EXPECT_GT(report["noise_floor_error_deg_per_h"], 0.0);
  EXPECT_TRUE(report["characterisation"]["ramp_deg_per_h_per_k_per_min"]["before"]["u"].is_null())
      << "the record is too short for it";
  EXPECT_LE(report["compensated"]["effective_count"], report["compensated"]["count"]);
  const auto words = verify("").out;
  for (const auto* word : {"n_eff", "angle random walk", "°/√h, read at τ = 3600 s", "noise floor of the record"})
    EXPECT_NE(words.find(word), std::string::npos) << words;
}

/// Only the selected 7200 s count.
TEST_F(Verify, TakesNoiseOnlyOfSelectedClusters) {
  const std::string command = "verify " + (*folder_ / "m.json") + " " + (*folder_ / "r.db") + " --json";
  const auto all = nlohmann::json::parse(gyrotherm_with(command).out), some = verify_as_json("");
  EXPECT_LT(some["allan"]["seconds"], all["allan"]["seconds"]);
  EXPECT_LE(some["allan"]["seconds"], 7200);
  EXPECT_GE(some["allan"]["seconds"], some["allan_compensated"]["seconds"]);
}

TEST_F(Verify, ReportsNoScatterOfSingleCluster) {
  const std::string command = "verify " + (*folder_ / "m.json") + " " + (*folder_ / "r.db") + " --clusters 100:101";
  const auto ran = gyrotherm_with(command);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto at = ran.out.find("raw bias");
  ASSERT_NE(at, std::string::npos) << ran.out;
  const std::string row = ran.out.substr(at, ran.out.find('\n', at) - at);
  EXPECT_EQ(row.find("0.00000"), std::string::npos) << row;
  EXPECT_NE(row.find("–         –"), std::string::npos) << row;
  const auto raw = nlohmann::json::parse(gyrotherm_with(command + " --json").out)["raw"];
  EXPECT_EQ(raw["count"], 1);
  for (const auto* error : {"std_error_deg_per_h", "mean_error_deg_per_h"}) EXPECT_TRUE(raw[error].is_null()) << error;
}

TEST_F(Verify, ReportsCoverageOfIntervals) {
  const auto coverage = verify_as_json("")["coverage"];
  EXPECT_EQ(coverage["nominal"], 0.95);
  EXPECT_GE(coverage["seen"], 0.0);
  EXPECT_LE(coverage["seen"], 1.0);
  EXPECT_GT(coverage["clusters"], 0);
  EXPECT_LE(coverage["effective"], coverage["clusters"]);
  EXPECT_GT(coverage["mean_half_width_deg_per_h"], 0.0);
  EXPECT_NE(verify("").out.find("95 % intervals"), std::string::npos);
}

/// The gyro is turned around and back at 20 °C. With one hour in each of three positions, 0.0003 °/√h give ± 0.0002
/// °/h.
TEST_F(Verify, SeparatesBiasAndEarthRateOfTurnedGyro) {
  const std::string record = *folder_ / "two.db";
  const auto recorded =
      gyrotherm_with("run profiles/two-position.toml --rig profiles/rigs/virtual.toml --seed 3 --out " + record);
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const std::string command = "verify " + (*folder_ / "m.json") + " " + record;
  const auto ran = gyrotherm_with(command + " --json");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto report = nlohmann::json::parse(ran.out);
  const auto& found = report["characterisation"]["two_position"];
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0]["set_point_c"], 20);
  EXPECT_EQ(found[0]["holds_as_mounted"], 2);
  EXPECT_EQ(found[0]["holds_turned"], 1);
  const auto& earth = found[0]["earth_rate_deg_per_h"]["before"];
  EXPECT_NEAR(earth["value"], found[0]["stated_earth_rate_deg_per_h"], 4 * earth["u"].get<double>());
  EXPECT_LT(earth["u"], 5e-4);
  const auto& bias = found[0]["bias_deg_per_h"]["before"];
  EXPECT_NEAR(bias["value"], report["raw"]["mean_deg_per_h"], 0.005);
  EXPECT_LT(report["raw"]["max_abs_deg_per_h"], 0.1) << "no second has the sign of the other position";
  const auto words = gyrotherm_with(command).out;
  EXPECT_NE(words.find("another gyro: it was trained on seed "), std::string::npos) << "than that of seed 3";
  for (const auto* word : {"bias, both positions", "earth rate, by turning", "the rig file states 10.63"})
    EXPECT_NE(words.find(word), std::string::npos) << words;
}

TEST_F(Verify, AssessesTrackingOnRequest) {
  EXPECT_FALSE(verify_as_json("").contains("tracking"));
  const std::string command = "verify " + (*folder_ / "m.json") + " " + (*folder_ / "r.db") + " --track";
  const auto ran = gyrotherm_with(command + " --json");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto tracking = nlohmann::json::parse(ran.out)["tracking"];
  EXPECT_NEAR(tracking["noise"]["angle_random_walk_deg_per_sqrt_h"].get<double>(), 3e-4, 1e-4)
      << "as in the model of the virtual gyro";
  EXPECT_GT(tracking["hours"], 0);
  EXPECT_EQ(tracking["denoisers"].size(), 9u);
  for (const auto& denoiser : tracking["denoisers"]) {
    const bool late = denoiser["latency_s"] > 0;
    EXPECT_EQ(denoiser["next_hour_rmse_deg_per_h"].is_null(), late) << denoiser["name"];
    EXPECT_TRUE(denoiser["rmse_to_truth_deg_per_h"].is_null()) << "the record does not contain it";
  }
  EXPECT_EQ(tracking["series"]["smoothed_deg_per_h"].size(), tracking["series"]["residual_deg_per_h"].size());
  const auto words = gyrotherm_with(command).out;
  for (const auto* word : {"hours predicted", "thermal model alone", "Kalman, an hour late", "Ljung–Box"})
    EXPECT_NE(words.find(word), std::string::npos) << words;
  EXPECT_EQ(verify("--noise " + (*folder_ / "r.db")).exit_code, 2) << "noise without tracking";
}

}  // namespace
}  // namespace gyrotherm::app
