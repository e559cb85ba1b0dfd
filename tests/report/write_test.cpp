// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "report/views.hpp"
#include "tests/report/synthetic_experiment.hpp"

namespace gyrotherm::report {
namespace {

namespace fs = std::filesystem;

/// Fixture with a temporary folder for each test.
class WriteReport : public testing::Test {
 protected:
  WriteReport() : folder_(fs::temp_directory_path() / ("gyrotherm-report-" + test_name())) { fs::remove_all(folder_); }
  ~WriteReport() override { fs::remove_all(folder_); }
  static std::string test_name() { return testing::UnitTest::GetInstance()->current_test_info()->name(); }
  std::string read(const char* name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  fs::path folder_;
};

TEST_F(WriteReport, WritesOnlyPageFiguresAndJson) {
  const std::string report = to_json(SyntheticExperiment().report());
  const auto written = write_report(report, folder_.string());
  ASSERT_TRUE(written.has_value()) << text(written.error());
  EXPECT_EQ(read("report.json"), report);
  EXPECT_TRUE(read("report.html").starts_with("<!DOCTYPE html>"));
  EXPECT_TRUE(read("figures/figure-8.svg").starts_with("<svg "));
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    files += entry.is_regular_file() ? 1 : 0;
  }
  EXPECT_GT(files, 6);
}

TEST_F(WriteReport, RebuildsEqualBytesFromJson) {
  ASSERT_TRUE(write_report(to_json(SyntheticExperiment().report()), folder_.string()).has_value());
  const std::string page = read("report.html");
  fs::remove(folder_ / "report.html");
  ASSERT_TRUE(rebuild_report(folder_.string()).has_value());
  EXPECT_EQ(read("report.html"), page);
}

TEST_F(WriteReport, WritesNothingForInvalidReport) {
  const auto written = write_report("{}", folder_.string());
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().kind, FaultKind::bad_file);
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(WriteReport, ReportsFolderThatCannotBeCreated) {
  std::ofstream(folder_) << "an existing file";
  const auto written = write_report(to_json(SyntheticExperiment().report()), folder_.string());
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().kind, FaultKind::storage);
}

TEST_F(WriteReport, RebuildRequiresReport) {
  const auto rebuilt = rebuild_report(folder_.string());
  ASSERT_FALSE(rebuilt.has_value());
  EXPECT_EQ(rebuilt.error().kind, FaultKind::bad_file);
}

}  // namespace
}  // namespace gyrotherm::report
