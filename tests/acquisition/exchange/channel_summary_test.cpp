// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/channel_summary.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "acquisition/exchange/import.hpp"
#include "acquisition/record/record.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

/// Imports 400 rows of one second with the given cells replaced.
class Imported {
 public:
  Result<ImportSummary> operator()(const std::vector<std::pair<int, std::string>>& temperatures,
                                   const std::vector<std::pair<int, std::string>>& rates = {}) {
    std::ofstream(folder_ / "map.toml") << "schema = \"gyrotherm-import/1\"\nname = \"m\"\n[file]\n"
                                        << file << "[time]\ncolumn = \"t\"\nunit = \"s\"\n"
                                        << time << "[[thermometer]]\nname = \"oven\"\ncolumn = \"T\"\n"
                                        << thermometer << "[gyro]\ncolumn = \"w\"\nkind = \"rate\"\nscale = 1\n";
    {
      std::ofstream table(folder_ / "table.csv");
      table << header;
      for (int i = 0; i < 400; ++i) table << row(i, temperatures, rates);
    }
    std::remove((folder_ / "run.db").c_str());
    std::remove((folder_ / "run.db.sha256").c_str());
    return import_record(
        folder_ / "table.csv", folder_ / "map.toml", folder_ / "run.db", "0.1.0", [] { return true; },
        std::chrono::seconds(1'800'000'000));
  }
  [[nodiscard]] std::string path() const { return folder_ / "run.db"; }

  std::string file, time, thermometer, header = "t,T,w\n", behind;

 private:
  std::string row(int i, const std::vector<std::pair<int, std::string>>& temperatures,
                  const std::vector<std::pair<int, std::string>>& rates) const {
    std::string temperature = std::to_string(20 + i / 20.), rate = std::to_string(i % 7);
    for (const auto& [at, text] : temperatures)
      if (at == i || at < 0) temperature = text;
    for (const auto& [at, text] : rates)
      if (at == i || at < 0) rate = text;
    return std::to_string(i) + "," + temperature + "," + rate + (behind.empty() ? "" : "," + behind) + "\n";
  }
  tests::TestFolder folder_;
};

/// The last row of an export is often an incomplete interval.
TEST(ChannelSummary, JudgesIncrementsByTheirCountingTimes) {
  const auto notes_of =
      [](const std::string& last_row, bool has_counting_times) {
        const tests::TestFolder folder;
        std::ofstream(folder / "map.toml")
            << "schema = \"gyrotherm-import/1\"\nname = \"m\"\n[time]\ncolumn = \"t\"\nunit = \"s\"\n"
            << "[gyro]\ncolumn = \"n\"\nkind = \"increment\"\nscale = 0.1\n"
            << (has_counting_times ? "interval_column = \"s\"\n" : "");
        {
          std::ofstream table(folder / "table.csv");
          table << "t,n,s\n";
          for (int i = 0; i < 60; ++i) table << 7 * i << "," << 740 + i % 5 << "," << 7.00003 + 1e-6 * (i % 3) << "\n";
          table << 7 * 60 << "," << last_row << "\n";
        }
        const auto summary = import_record(folder / "table.csv", folder / "map.toml", folder / "run.db", "0.1.0");
        EXPECT_TRUE(summary) << text(summary.error());
        return summary ? summary->notes : Notes{"failed"};
      };
  EXPECT_EQ(notes_of("318,3.00001", true), Notes{});
  EXPECT_EQ(notes_of("318,3.00001", false).size(), 1u);
  const auto wild = notes_of("740,3.00001", true);
  ASSERT_EQ(wild.size(), 1u) << "the increment is usual, the rate is not";
  EXPECT_NE(wild.front().find(" °/h or more from all others, the furthest at 24.6"), std::string::npos) << wild.front();
}

TEST(ChannelSummary, DescribesEachChannel) {
  Imported import;
  import.file = "missing = [\"---\", \"-999.9\"]\n";
  const auto summary = import({{3, "---"}, {4, "---"}, {5, "-999.90"}});
  ASSERT_TRUE(summary) << text(summary.error());
  ASSERT_EQ(summary->channels.size(), 2u);
  EXPECT_EQ(describe(summary->channels[0]), "oven: 397 values, 20 to 39.95 °C, 3 missing (\"---\" 2, \"-999.90\" 1)");
  EXPECT_EQ(describe(summary->channels[1]), "gyro: 400 values, 0 to 6 °/h");
  EXPECT_EQ(summary->step, kSecond);
  EXPECT_EQ(summary->file_rows, 400u);
  const auto made = record::read_record(import.path()).value();
  EXPECT_NE(made.events.back().event.text.find("oven: 397 values, 20 to 39.95 °C"), std::string::npos);
}

TEST(ChannelSummary, RefusesImpossibleValues) {
  Imported import;
  for (const char* number : {"9.9E+37", "-9.9e37", "1e30", "-273.2", "-8884", "6000"}) {
    const auto summary = import({{7, number}});
    ASSERT_FALSE(summary) << number;
    EXPECT_NE(summary.error().where.find("table.csv:9:1"), std::string::npos) << text(summary.error());
    EXPECT_NE(summary.error().what.find("\"T\""), std::string::npos);
  }
  for (const char* number : {"9.9E+37", "1e9"}) EXPECT_FALSE(import({}, {{7, number}})) << number;
}

TEST(ChannelSummary, RefusesIsolatedTemperatures) {
  Imported import;
  for (const std::vector<std::pair<int, std::string>>& codes : {std::vector<std::pair<int, std::string>>{{7, "-127"}},
                                                                {{7, "-127"}, {9, "-127"}, {80, "-127"}},
                                                                {{7, "-99.9"}},
                                                                {{100, "850"}, {101, "850"}},
                                                                {{7, "198.4"}, {30, "201.5"}}}) {
    const auto summary = import(codes);
    ASSERT_FALSE(summary) << codes.front().second;
    EXPECT_NE(summary.error().what.find("or more from all others"), std::string::npos) << text(summary.error());
  }
  import.thermometer = "valid = [-60, 120]\n";
  const auto valid = import({{7, "-127"}, {9, "850"}});
  ASSERT_TRUE(valid) << text(valid.error());
  EXPECT_EQ(valid->channels[0].outside, 2u);
  EXPECT_EQ(valid->channels[0].least, 20);
  import.thermometer = "";
  const auto near = import({{7, "62"}});
  ASSERT_TRUE(near) << text(near.error());
  ASSERT_EQ(near->notes.size(), 1u) << "22 K above all others is reported";
}

TEST(ChannelSummary, ReportsOrRefusesEmptyAndConstantChannels) {
  Imported import;
  import.file = "missing = [\"-\"]\n";
  EXPECT_FALSE(import({}, {{-1, "-"}})) << "an axis without a value";
  const auto empty = import({{-1, "-"}});
  ASSERT_TRUE(empty) << text(empty.error());
  EXPECT_EQ(empty->notes, (Notes{"column \"T\" has no value for oven: \"-\" 400"}));
  const auto constant = import({{-1, "21"}});
  ASSERT_TRUE(constant);
  EXPECT_EQ(constant->notes, Notes{"all 400 values of oven are 21 °C"});
}

TEST(ChannelSummary, RefusesRowsOfSingleStretch) {
  Imported import;
  for (const char* every : {"10 min", "1 h", "30 d"}) {
    import.time = "every = \"" + std::string(every) + "\"\n";
    const auto summary = import({});
    ASSERT_FALSE(summary) << every;
    EXPECT_NE(summary.error().what.find("all 400 rows fall into one interval"), std::string::npos);
  }
}

TEST(ChannelSummary, RefusesTimeThatContradictsOtherColumn) {
  Imported import;
  import.header = "t,T,w,logged\n";
  for (const char* first : {"2026-03-01T08:00:00Z", "01.03.2026 08:00:00", "3/1/2026 8:00:00 AM"}) {
    import.behind = first;
    EXPECT_TRUE(import({})) << "a constant date shows no duration";
  }
  const tests::TestFolder folder;
  for (const auto& [first, last] :
       {std::pair("2026-03-01 08:00:00", "2026-03-01 11:00:00"), std::pair("01.03.2026 23:00", "02.03.2026 01:00"),
        std::pair("08:00:00", "11:00:00")}) {
    std::ofstream(folder / "m.toml")
        << "schema = \"gyrotherm-import/1\"\nname = \"m\"\n[file]\n[time]\ninterval = \"1 s\"\n[gyro]\n"
           "column = \"w\"\nkind = \"rate\"\nscale = 1\n";
    std::ofstream(folder / "t.csv") << "when,w\n" << first << ",1\n" << first << ",2\n" << last << ",3\n";
    const auto summary = import_record(folder / "t.csv", folder / "m.toml", folder / "run.db", "0.1.0");
    ASSERT_FALSE(summary) << first;
    EXPECT_NE(summary.error().what.find("by column \"when\""), std::string::npos) << text(summary.error());
  }
}

TEST(ChannelSummary, RefusesErrorCodeOfDeadSensorHoweverLong) {
  Imported import;
  for (const char* code : {"-127", "850"})
    for (const int first : {100, 200, 390}) {
      std::vector<std::pair<int, std::string>> cells;
      for (int row = first; row < 400; ++row) cells.emplace_back(row, code);
      const auto summary = import(cells);
      ASSERT_FALSE(summary) << code << " from " << first;
      EXPECT_NE(summary.error().what.find("missing = [\"" + std::string(code) + "\"]"), std::string::npos)
          << text(summary.error());
    }
}

TEST(ChannelSummary, WarnsAboutMissingPartAndStoresWarning) {
  Imported import;
  import.file = "missing = [\"OPEN\"]\n";
  std::vector<std::pair<int, std::string>> cells;
  for (int row = 200; row < 400; ++row) cells.emplace_back(row, "OPEN");
  const auto summary = import(cells);
  ASSERT_TRUE(summary) << text(summary.error());
  ASSERT_EQ(summary->notes.size(), 1u);
  EXPECT_EQ(summary->notes[0].rfind("warning: 200 of 400 values of oven are missing (50 %)", 0), 0u)
      << summary->notes[0];
  const auto made = record::read_record(import.path()).value();
  EXPECT_EQ(made.events.front().event.text, summary->notes[0]);
  cells.resize(20);
  EXPECT_EQ(import(cells)->notes, Notes{}) << "5 %";
}

TEST(ChannelSummary, DoesNotWarnAboutSlowColumnOfCombinedRows) {
  Imported import;
  import.time = "every = \"10 s\"\n";
  import.file = "missing = [\"\"]\n";
  std::vector<std::pair<int, std::string>> cells;
  for (int row = 0; row < 400; ++row)
    if (row % 5 != 0) cells.emplace_back(row, "");
  const auto summary = import(cells);
  ASSERT_TRUE(summary) << text(summary.error());
  for (const auto& note : summary->notes) EXPECT_EQ(note.find("warning"), std::string::npos) << note;
}

TEST(ChannelSummary, AsksForScaleOfRawCountsFirst) {
  Imported import;
  const auto raw = import({{-1, "-5629"}});
  ASSERT_FALSE(raw);
  const auto scale = raw.error().what.find("scale and offset"), missing = raw.error().what.find("missing = ");
  EXPECT_LT(scale, missing) << raw.error().what;
  const auto late = import({{200, "5200"}});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().what.find("scale and offset"), std::string::npos) << late.error().what;
}

}  // namespace
}  // namespace gyrotherm::exchange
