// SPDX-License-Identifier: Apache-2.0
/// The whole experiment in small: profiles of a few hours, a quick swarm.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kSmall =
    " --quick --rate-profile tests/profiles/short-rate.toml --random-profile tests/profiles/short-random.toml";

nlohmann::json report_in(const std::string& folder) {
  return nlohmann::json::parse(read_text_file(folder + "/report/report.json", kLargestTable).value());
}

TEST(Qualify, WritesAllPromisedFiles) {
  const Folder folder;
  const auto out = folder / "out";
  const auto ran = gyrotherm_with("qualify --out " + out + kSmall);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_TRUE(ran.out.starts_with("SIMULATED")) << ran.out;
  const auto last = ran.err.rfind("result:      ridge-u on thermal-history lowers the STD of an unseen run from ");
  ASSERT_NE(last, std::string::npos) << ran.err;
  EXPECT_EQ(std::count(ran.err.begin() + static_cast<std::ptrdiff_t>(last), ran.err.end(), '\n'), 3);
  EXPECT_NE(ran.err.find("\nuncertainty: U = ", last), std::string::npos) << ran.err;
  EXPECT_TRUE(ran.err.ends_with("\nreport:      " + out + "/report/report.html\n")) << ran.err;
  for (const auto* name :
       {"ramp.db", "random.db", "model-three-point.json", "model-multi-point.json", "model-multi-point-t.json",
        "model-recommended.json", "report/report.json", "report/report.html", "timings.json"})
    EXPECT_TRUE(std::filesystem::exists(out + "/" + name)) << name;
  const auto report = report_in(out);
  EXPECT_EQ(report["schema"], "gyrotherm-report/1");
  EXPECT_EQ(report["rig"]["virtual"], true);
  EXPECT_LT(report["rate"]["multi_point_t"]["std_deg_per_h"], report["rate"]["raw"]["std_deg_per_h"]);
  EXPECT_EQ(report["recommendation"]["recommended"], "ridge-u-thermal-history");
  const auto statement = report["recommendation"]["statement"].get<std::string>();
  EXPECT_NE(statement.find("the rule was not applied to this gyro"), std::string::npos) << statement;
  EXPECT_EQ(report["recommendation"]["records"], 0) << "no record to select a model with";
  EXPECT_EQ(report["methods"].size(), 4) << "the others are trained with --compare or --further";
  const auto html = read_text_file(out + "/report/report.html", kLargestTable).value();
  EXPECT_NE(html.find("SIMULATED"), std::string::npos);
  for (const auto& [run, file] : {std::pair("rate", "/ramp.db"), std::pair("random", "/random.db")}) {
    const auto& provenance = report["provenance"][run];
    const auto bytes = sha256(read_text_file(out + file, kLargestTable).value());
    EXPECT_EQ(provenance["record_file_sha256"], bytes) << file;
    EXPECT_NE(provenance["record_sha256"], bytes) << file;
    EXPECT_NE(html.find(bytes), std::string::npos) << file;
  }
  const auto figure = nlohmann::json::parse(shell(GYROTHERM_PROGRAM "-thermal figure").out);
  const auto& thermal = report["thermal"];
  EXPECT_EQ(thermal["missing"], "") << thermal["reason"];
  for (const char* key : {"gyro", "gyro_sha256", "materials", "sources", "image"})
    EXPECT_EQ(thermal["model"][key], figure[key]) << key;
  EXPECT_NE(html.find("<figure id=\"figure-1\""), std::string::npos);

  const auto again = gyrotherm_with("qualify --out " + out + kSmall);
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("already recorded"), std::string::npos) << "existing records are kept";
  EXPECT_EQ(report_in(out)["provenance"], report["provenance"]) << "also with stored digests";
  const auto other = gyrotherm_with("qualify --seed 9 --out " + out + kSmall);
  EXPECT_EQ(other.exit_code, 2) << "another experiment is refused in the same folder";
}

TEST(Qualify, ReportsImageNotApplicableWithoutFiniteElements) {
  const Folder folder;
  const auto out = folder / "out";
  const auto ran = gyrotherm_with("qualify --rig virtual-reference --out " + out + kSmall);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto thermal = report_in(out)["thermal"];
  EXPECT_EQ(thermal["missing"], "not applicable");
  EXPECT_NE(thermal["reason"].get<std::string>().find("consists of lumps"), std::string::npos) << thermal;
  EXPECT_TRUE(thermal["model"].is_null());
}

/// Trains like the tasks of a cluster. tests/apps/site shows that all tasks together give the same result as one
/// machine.
TEST(Qualify, TrainsOneAxisOfLotWithoutOthers) {
  const Folder folder;
  const auto out = folder / "out";
  const auto command = "qualify --rig virtual-triad --out " + out + kSmall;
  const auto unknown = gyrotherm_with(command + " --only w");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("\"w\"; the axes are x, y, z"), std::string::npos) << unknown.err;
  EXPECT_FALSE(std::filesystem::exists(out)) << "before any work";
  EXPECT_EQ(gyrotherm_with("qualify --only gyro --out " + out + kSmall).exit_code, 2)
      << "one axis is not recommended separately";

  const auto ran = gyrotherm_with(command + " --only z");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("\nz "), std::string::npos) << ran.out;
  EXPECT_TRUE(std::filesystem::exists(out + "/z/report/report.json"));
  EXPECT_FALSE(std::filesystem::exists(out + "/y"));
  EXPECT_FALSE(std::filesystem::exists(out + "/lot.json")) << "a part of a lot has no recommendation";
}

TEST(Qualify, RetrainsAxisWhenOptionsChange) {
  const Folder folder;
  const auto out = folder / "out";
  const auto command = "qualify --rig virtual-triad --only z --out " + out + kSmall;
  const auto is_nested = [&] { return !report_in(out + "/z")["methods"][0]["nested_leave_cycle_out"].is_null(); };
  const auto plain = gyrotherm_with(command);
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_FALSE(is_nested());
  const auto nested = gyrotherm_with(command + " --nested");
  ASSERT_EQ(nested.exit_code, 0) << nested.err;
  EXPECT_TRUE(is_nested()) << "the earlier report has no such results";
}

/// A stored digest is used only for files with the same bytes.
TEST(Qualify, RefusesRecordChangedAfterwards) {
  const Folder folder;
  const auto out = folder / "out";
  const auto command = "qualify --records-only --out " + out + kSmall;
  ASSERT_EQ(gyrotherm_with(command).exit_code, 0);
  ASSERT_EQ(gyrotherm_with(command).exit_code, 0) << "existing records are used";
  ASSERT_TRUE(std::filesystem::exists(out + "/digests.json"));
  auto record = read_text_file(out + "/random.db", kLargestTable).value();
  record[record.size() / 2] ^= 1;
  std::ofstream(out + "/random.db", std::ios::binary) << record;
  const auto ran = gyrotherm_with(command);
  EXPECT_EQ(ran.exit_code, 4) << ran.err;
  EXPECT_NE(ran.err.find("random.db"), std::string::npos) << ran.err;
}

/// The run of the headline figures never chooses a model.
TEST(Qualify, RecommendsOnlyOnFurtherRecords) {
  const Folder folder;
  const auto out = folder / "out";
  ASSERT_EQ(
      gyrotherm_with("run tests/profiles/short-random.toml --rig profiles/rigs/virtual.toml --days-later 30 --out " +
                     (folder / "later.db"))
          .exit_code,
      0);
  ASSERT_EQ(gyrotherm_with("run tests/profiles/short-random.toml --rig profiles/rigs/virtual.toml --seed 5 --out " +
                           (folder / "other.db"))
                .exit_code,
            0);
  const auto ran = gyrotherm_with("qualify --out " + out + kSmall + " --further " + (folder / "later.db"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto found = report_in(out)["recommendation"];
  EXPECT_NE(found["recommended"], "");
  EXPECT_EQ(found["records"], 2) << "the further record, and the ramp run by models trained on it";
  EXPECT_GT(report_in(out)["methods"].size(), 10);
  EXPECT_NE(ran.out.find("recommended: " + found["recommended"].get<std::string>()), std::string::npos) << ran.out;
  const auto other = gyrotherm_with("qualify --out " + out + kSmall + " --further " + (folder / "other.db"));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.err.find("belongs to a different gyro (seed 5)"), std::string::npos) << other.err;
  for (const auto* quoted : {"random.db", "ramp.db"})
    EXPECT_EQ(gyrotherm_with("qualify --out " + out + kSmall + " --further " + out + "/" + quoted).exit_code, 2);
}

/// Covers later runs of the same gyro, made by the virtual rig or recorded before.
TEST(Qualify, VerifiesEveryModelLater) {
  const Folder folder;
  const auto out = folder / "out";
  ASSERT_EQ(
      gyrotherm_with("run tests/profiles/short-random.toml --rig profiles/rigs/virtual.toml --days-later 365 --out " +
                     (folder / "year.db"))
          .exit_code,
      0);
  const auto ran = gyrotherm_with("qualify --out " + out + kSmall + " --verify-later 30," + (folder / "year.db"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("30 days later"), std::string::npos) << ran.out;
  const auto report = report_in(out);
  ASSERT_EQ(report["later"].size(), 2);
  EXPECT_EQ(report["later"][0]["name"], "30 days later");
  EXPECT_EQ(report["later"][1]["name"], "year.db");
  EXPECT_NE(report["later"][0]["record_sha256"], report["provenance"]["random"]["record_sha256"]);
  for (const auto& method : report["methods"]) {
    ASSERT_EQ(method["later"].size(), 2) << method["name"];
    for (const auto& later : method["later"]) {
      EXPECT_GT(later["rmse_deg_per_h"].get<double>(), 0);
      EXPECT_GT(later["coverage"]["seen"].get<double>(), 0);
      EXPECT_TRUE(later["to_truth"].is_object());
    }
  }
  for (const auto* wrong : {"0", "99999", "x"})
    EXPECT_EQ(gyrotherm_with("qualify --out " + out + kSmall + " --verify-later " + wrong).exit_code, 2) << wrong;
  EXPECT_EQ(gyrotherm_with("qualify --out " + out + kSmall + " --verify-later " + out + "/random.db").exit_code, 2);
}

/// Both runs of a virtual rig are recorded at the same time. Each stops at Ctrl-C and is resumed.
TEST(Qualify, ResumesBothRunsAfterInterrupt) {
  const Folder folder;
  const auto out = folder / "out";
  const std::string profiles = GYROTHERM_SOURCE_DIR "/tests/profiles/";
  const std::vector<std::string> records = {out + "/ramp.db", out + "/random.db"};
  Background qualify({"qualify", "--records-only", "--threads", "2", "--out", out, "--rate-profile",
                      profiles + "short-rate.toml", "--random-profile", profiles + "short-random.toml"},
                     folder / "output");
  const auto have_begun = [&] {
    return std::ranges::all_of(records, [](const auto& path) { return std::filesystem::exists(path + ".status"); });
  };
  while (qualify.is_running() && !have_begun()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ASSERT_TRUE(qualify.is_running()) << qualify.output();
  qualify.signal(SIGINT);
  EXPECT_EQ(qualify.wait(), 5) << qualify.output();
  const auto is_finished = [](const std::string& path) {
    return nlohmann::json::parse(read_text_file(path + ".status").value())["finished"].get<bool>();
  };
  for (const auto& path : records) EXPECT_FALSE(is_finished(path)) << path;
  const auto resumed = gyrotherm_with("qualify --records-only --threads 2 --out " + out + kSmall);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  for (const auto& path : records) EXPECT_TRUE(is_finished(path)) << path;
}

TEST(Qualify, OneSeedGivesOneReportForAnyThreadCount) {
  const Folder folder;
  ASSERT_EQ(gyrotherm_with("qualify --seed 3 --threads 1 --out " + (folder / "a") + kSmall).exit_code, 0);
  ASSERT_EQ(gyrotherm_with("qualify --seed 3 --threads 2 --out " + (folder / "b") + kSmall).exit_code, 0);
  EXPECT_EQ(read_text_file(folder / "a/report/report.json", kLargestTable).value(),
            read_text_file(folder / "b/report/report.json", kLargestTable).value());
  ASSERT_EQ(gyrotherm_with("qualify --seed 4 --out " + (folder / "c") + kSmall).exit_code, 0);
  EXPECT_NE(read_text_file(folder / "a/report/report.json", kLargestTable).value(),
            read_text_file(folder / "c/report/report.json", kLargestTable).value());
}

TEST(Qualify, ModelPredictsSameInLibsvm) {
  if (!installed("svm-predict")) GTEST_SKIP() << "svm-predict (package libsvm-tools) is not installed";
  const Folder folder;
  const auto run =
      "gyrotherm run tests/profiles/short-rate.toml --rig profiles/rigs/virtual.toml --out " + (folder / "r.db");
  ASSERT_EQ(shell(run).exit_code, 0);
  ASSERT_EQ(
      gyrotherm_with("train " + (folder / "r.db") + " --quick --inputs multi-point-t --out " + (folder / "m.json"))
          .exit_code,
      0);
  ASSERT_EQ(
      gyrotherm_with("export-model " + (folder / "m.json") + " --as libsvm --out " + (folder / "m.svm")).exit_code, 0);
  ASSERT_EQ(gyrotherm_with("export-model " + (folder / "m.json") + " --as libsvm --data " + (folder / "r.db") +
                           " --out " + (folder / "x.svm"))
                .exit_code,
            0);
  const auto predicted =
      shell("svm-predict " + (folder / "x.svm") + " " + (folder / "m.svm") + " " + (folder / "y.txt"));
  ASSERT_EQ(predicted.exit_code, 0) << predicted.err;

  // The residual of verify is target − f(z), in units of the training STD.
  std::istringstream targets(read_text_file(folder / "x.svm").value()),
      values(read_text_file(folder / "y.txt").value());
  const auto model = nlohmann::json::parse(read_text_file(folder / "m.json").value());
  double sum = 0, sum_of_squares = 0;
  int count = 0;
  for (std::string row; std::getline(targets, row); ++count) {
    double prediction{};
    values >> prediction;
    const double residual = std::stod(row) - prediction;
    sum += residual;
    sum_of_squares += residual * residual;
  }
  ASSERT_GT(count, 10);
  const double std = std::sqrt((sum_of_squares - sum * sum / count) / (count - 1));
  const auto verified = gyrotherm_with("verify --json " + (folder / "m.json") + " " + (folder / "r.db"));
  const auto figures = nlohmann::json::parse(verified.out);
  EXPECT_NEAR(figures["compensated"]["std_deg_per_h"].get<double>() / figures["raw"]["std_deg_per_h"].get<double>(),
              std, 1e-5);
}

TEST(CompensateOfAnExperiment, StreamsRowsAndStatesItsLag) {
  const Folder folder;
  const auto run =
      "gyrotherm run tests/profiles/short-rate.toml --rig profiles/rigs/virtual.toml --out " + (folder / "r.db");
  ASSERT_EQ(shell(run).exit_code, 0);
  ASSERT_EQ(gyrotherm_with("train " + (folder / "r.db") + " --method linear --inputs three-point --out " +
                           (folder / "m.json"))
                .exit_code,
            0);
  std::string rows = "A,D,shell,bias\n";
  for (int i = 0; i < 150; ++i) rows += "23.1,21.8,20.9,0.021\n";
  const auto ran = gyrotherm_with("compensate " + (folder / "m.json"), rows);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.err.find("lag by 50 s"), std::string::npos);
  EXPECT_EQ(std::count(ran.out.begin(), ran.out.end(), '\n'), 151);
  const auto bad = gyrotherm_with("compensate " + (folder / "m.json"), "A,D,shell,bias\n1,2,x,4\n");
  EXPECT_EQ(bad.exit_code, 4);
  EXPECT_NE(bad.err.find("stdin:2:5"), std::string::npos) << bad.err;
}

}  // namespace
}  // namespace gyrotherm::app
