// SPDX-License-Identifier: Apache-2.0
/// The option --days-later, and results compared with the true bias.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "acquisition/record/record.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

TEST(DaysLater, ComparesModelWithTrueBiasOfNextYear) {
  const Folder folder;
  const std::string run = "run tests/profiles/short-rate.toml --rig profiles/rigs/virtual-hard.toml --seed 2 ";
  const auto now = gyrotherm_with(run + "--out " + (folder / "now.db"));
  ASSERT_EQ(now.exit_code, 0) << now.err;
  const auto later = gyrotherm_with(run + "--days-later 365 --out " + (folder / "later.db"));
  ASSERT_EQ(later.exit_code, 0) << later.err;
  const auto info = record::read_record(folder / "later.db")->info;
  EXPECT_EQ(info.days_later, 365u);
  EXPECT_EQ(info.started_utc - record::read_record(folder / "now.db")->info.started_utc, std::chrono::days(365));
  const auto model = folder / "m.json";
  const auto trained =
      gyrotherm_with("train " + (folder / "now.db") + " --method linear --inputs seven-point --out " + model);
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const auto to_truth = [&](const std::string& record) {
    const auto ran = gyrotherm_with("verify --json " + model + " " + (folder / record));
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return nlohmann::json::parse(ran.out)["to_truth"];
  };
  const auto today = to_truth("now.db"), next_year = to_truth("later.db");
  EXPECT_FALSE(today["mean_removed"].get<bool>()) << "the Earth rate is known";
  EXPECT_GT(next_year["rmse_deg_per_h"].get<double>(), 1.2 * today["rmse_deg_per_h"].get<double>());
  const auto words = gyrotherm_with("verify " + model + " " + (folder / "later.db")).out;
  EXPECT_NE(words.find("error vs. true bias"), std::string::npos) << words;
}

TEST(DaysLater, IsRefusedForRealRig) {
  const Folder folder;
  const std::string rig = " --rig profiles/rigs/example-f4t-lakeshore-kvh.toml --days-later 30 --out ";
  const auto run = gyrotherm_with("run tests/profiles/ten-seconds.toml" + rig + (folder / "r.db"));
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_NE(run.err.find("--days-later"), std::string::npos) << run.err;
  const auto qualify = gyrotherm_with("qualify" + rig + (folder / "out"));
  EXPECT_EQ(qualify.exit_code, 2) << qualify.err;
}

}  // namespace
}  // namespace gyrotherm::app
