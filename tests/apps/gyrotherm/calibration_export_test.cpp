// SPDX-License-Identifier: Apache-2.0
/// Tables of the compensated rows of a calibrated unit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "acquisition/record/sqlite.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/calibrated_unit.hpp"

namespace gyrotherm::app {
namespace {

TEST_F(CalibrationOfAUnit, CompensateReadsExportedRows) {
  run("export " + in("random.db") + " --out " + in("random.csv"));
  run("export " + in("random.db") + " --compensated --model " + in("model.json") + " --out " + in("compensated.csv"));
  const auto stream = gyrotherm_with("compensate " + in("model.json"), read_text(in("random.csv")));
  ASSERT_EQ(stream.exit_code, 0) << stream.err;
  const std::string table = read_text(in("compensated.csv"));
  EXPECT_NE(table.find("# SIMULATED"), std::string::npos);
  EXPECT_NE(table.find(",bias [°/h],compensated [°/h],U of a mean over 100 s [°/h]\n"), std::string::npos);
  const auto last_of = [](std::string text, int from_behind) {
    text.pop_back();
    text = text.substr(text.rfind('\n') + 1);
    for (; from_behind > 0; --from_behind) text = text.substr(0, text.rfind(','));
    return std::stod(text.substr(text.rfind(',') + 1));
  };
  EXPECT_NEAR(last_of(stream.out, 0), last_of(table, 1), 1e-6);
}

TEST_F(CalibrationOfAUnit, ExportsCompensatedRowsWithSameTimes) {
  const auto exported = [&](const std::string& how) {
    run("export " + in("random.db") + " --from '10 min' --to '602 s' --force --out " + in("chosen.csv") + how);
    return read_text(in("chosen.csv"));
  };
  const auto plain = exported(""), compensated = exported(" --compensated --model " + in("model.json"));
  for (const char* time : {"600", "601", "602"}) {
    EXPECT_NE(plain.find(fmt::format("\n{},{},", std::stoi(time) - 1, time)), std::string::npos) << plain;
    EXPECT_NE(compensated.find(fmt::format("\n{},", time)), std::string::npos) << compensated;
  }
  EXPECT_EQ(std::ranges::count(compensated, '\n') - std::ranges::count(compensated, '#'), 4);
  for (const std::string& how : {std::string(), " --compensated --model " + in("model.json")}) {
    const auto none = gyrotherm_with("export " + in("random.db") + " --from '900 h' --out " + in("none.csv") + how);
    EXPECT_EQ(none.exit_code, 2) << how;
    EXPECT_NE(none.err.find("the record has no row in the selected range"), std::string::npos) << none.err;
    EXPECT_FALSE(std::filesystem::exists(in("none.csv")));
  }
}

TEST_F(CalibrationOfAUnit, LeavesMeansEmptyAcrossGap) {
  std::filesystem::copy_file(in("random.db"), in("gap.db"));
  {
    auto record = record::Database::open(in("gap.db"), record::Access::read_write, 0).value();
    ASSERT_TRUE(record.execute("DELETE FROM sample WHERE slot BETWEEN 1000 AND 1009"));
  }
  run("export " + in("gap.db") + " --unverified --compensated --model " + in("model.json") + " --out " + in("gap.csv"));
  const auto compensated = [table = read_text(in("gap.csv"))](int second) {
    auto line = table.substr(table.find(fmt::format("\n{},", second + 1)) + 1);  // a second is sampled at its end
    line = line.substr(0, line.find('\n'));
    line = line.substr(0, line.rfind(','));
    return line.substr(line.rfind(',') + 1);
  };
  EXPECT_NE(compensated(999), "");
  EXPECT_EQ(compensated(1010), "") << "the means of the last 100 s are unknown";
  EXPECT_EQ(compensated(1108), "");
  EXPECT_NE(compensated(1209), "");
}

}  // namespace
}  // namespace gyrotherm::app
