// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/text_table.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/acquisition/exchange/foreign.hpp"

namespace gyrotherm::exchange {
namespace {

using record::GyroKind;

/// Returns the map of a table without a header. Its columns are time, thermometer, and the gyro's at `axis`.
ImportMap numbered_map(int axis) {
  ImportMap map = rate_map();
  map.header = false;
  map.time->number = 1;
  map.thermometer_columns[0].column.number = 2;
  map.axis_columns[0].number = axis;
  return map;
}

TEST(TextTable, ReadsColumnsByNameInAnyOrder) {
  const auto rows = read_rows("w,x,T,t\n7,?,20,1000\n-8.5,,1e1,1500\n", rate_map(), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->time, (std::vector<Duration>{{}, std::chrono::milliseconds(500)}));
  EXPECT_EQ(rows->columns[0], (std::vector<double>{20, 10}));
  EXPECT_EQ(rows->columns[1], (std::vector<double>{7, -8.5}));
}

TEST(TextTable, AcceptsCrLfByteOrderMarkBlanksQuotesCommentsAndEmptyLines) {
  ImportMap map = rate_map();
  map.comment = "%";
  const std::string bytes = "\xEF\xBB\xBF% made by hand\r\n\"T \", t ,w\r\n\r\n\"20\", 0 ,+1\r\n% pause\r\n21,1,2";
  const auto rows = read_rows(bytes, map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{1, 2}));
  EXPECT_EQ(rows->columns[0], (std::vector<double>{20, 21}));
}

TEST(TextTable, TreatsBlanksAsOneSeparatorAndSkipsLeadingLines) {
  ImportMap map;
  map.separator = ' ';
  map.header = false;
  map.skip = 2;
  map.interval = std::chrono::milliseconds(10);
  map.units = rate_map().units;
  map.axis_columns = {{.number = 3}};
  const auto rows = read_rows("a b\nc\n 1  2 3 \n4\t5 6\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[0], (std::vector<double>{3, 6}));
  EXPECT_EQ(rows->time[1], std::chrono::milliseconds(10));
  EXPECT_EQ(rows->interval[1], std::chrono::milliseconds(10));
}

TEST(TextTable, ReportsPositionOfEveryKindOfError) {
  struct Case {
    const char* bytes;
    const char* said;
  };
  for (const Case& bad : {
           Case{"", "f:1:1: the file ends, expected a header"},
           Case{"t,T,w\n", "f:1:1: the file ends, expected at least one row"},
           Case{"t,T\n1,2\n", "f:1:1: no column \"w\", expected one of: \"t\", \"T\""},
           Case{"t,T,w,T \n1,2,3,4\n", "f:1:7: a second column \"T\", expected one, or column_number = 2 in the map"},
           Case{"t,T,w\n1,2\n", "f:2:1: 2 fields, expected 3"},
           Case{"t,T,w\n1,2,3,4\n", "f:2:1: 4 fields, expected 3"},
           Case{"t,T,w\n1,2,3\n2,nan,3\n",
                "f:3:3: \"nan\" in column \"T\", expected a number, or missing = [\"nan\"] in [file]"},
           Case{"t,T,w\n1,2,inf\n",
                "f:2:5: \"inf\" in column \"w\", expected a number, or missing = [\"inf\"] in [file]"},
           Case{"t,T,w\n1,2,1e999\n", "f:2:5: \"1e999\" in column \"w\", expected a number"},
           Case{"t,T,w\n1,,3\n", "f:2:3: \"\" in column \"T\", expected a number, or missing = [\"\"] in [file]"},
           Case{"t,T,w\n1,2,3x\n",
                "f:2:5: \"3x\" in column \"w\", expected a number, or cell_units = [\"x\"] in [file]"},
           Case{"t,T,w\n1,2,0x10\n", "f:2:5: \"0x10\" in column \"w\", expected a number"},
           Case{"t,T,w\n1,\"2,5\",3\n", "f:2:3: \"2,5\" in column \"T\", expected a number with a decimal point"},
           Case{"t,T,w\n,2,3\n", "f:2:1: \"\" in column \"t\", expected a number"},
           Case{"t,T,w\rn0,2,3\n", "f:1:6: a carriage return within the line, expected lines that end with LF or CRLF"},
           Case{"t,T,w\n1,\"2,3\n", "f:2:3: a quote is not closed, expected \" before the end of the line"},
           Case{"t,T,w\n1,\"2\"5,3\n", "f:2:6: text after a closing quote, expected a separator"},
           Case{"t,T,w\n5,2,3\n5,2,3\n",
                "f:3:1: the time does not increase, expected one after the row before, or out_of_order = "
                "\"skip\" in [time]"},
           Case{"t,T,w\n5,2,3\n4,2,3\n",
                "f:3:1: the time goes back 0.001 s, expected one after the row before, or out_of_order = "
                "\"skip\" in [time]"},
           Case{"t,T,w\n0,2,3\n1e15,2,3\n", "f:3:1: more than ten years after the first row"},
       }) {
    const auto rows = read_rows(bad.bytes, rate_map(), "f");
    ASSERT_FALSE(rows) << bad.bytes;
    EXPECT_EQ(rows.error().kind, FaultKind::bad_file);
    EXPECT_EQ(text(rows.error()), bad.said);
  }
}

TEST(TextTable, LimitsLineLengthAndFieldCount) {
  const std::string header = "t,T,w\n", row = "1,2,3\n";
  const auto said = [&](const std::string& bytes) {
    const auto rows = read_rows(bytes, rate_map(), "f");
    return rows ? "read" : text(rows.error());
  };
  EXPECT_EQ(said(header + row + std::string(200'000'000, ',')),
            "f:3:65537: more than 65536 bytes in a line, expected fewer");
  EXPECT_EQ(said(header + row + "1,2,3" + std::string(65536, ' ') + "\n"),
            "f:3:65537: more than 65536 bytes in a line, expected fewer");
  EXPECT_EQ(said(header + row + std::string(5000, ',') + "\n"), "f:3:4097: more than 4096 fields, expected fewer");
  EXPECT_EQ(said(header + row + std::string(70'000, ' ') + "\n"), "read") << "an empty line does not count";
  ImportMap blanks = rate_map();
  blanks.separator = ' ';
  std::string wide;
  for (int i = 0; i < 5000; ++i) wide += "1 ";
  EXPECT_EQ(text(read_rows(wide + "\n", blanks, "f").error()), "f:1:8193: more than 4096 fields, expected fewer");
}

TEST(TextTable, NamesMissingColumnNumber) {
  ImportMap map = numbered_map(4);
  EXPECT_EQ(text(read_rows("1,2,3\n", map, "f").error()), "f:1:1: 3 columns, expected at least 4");
  EXPECT_EQ(text(read_rows("1;2;3;4\n", map, "f").error()),
            "f:1:1: 1 column, expected at least 4; the line has separators \";\": set separator = \";\" in [file]");
  map.skip = 2;
  EXPECT_EQ(text(read_rows("1,2,3\n", map, "f").error()), "f:1:1: the file ends within the lines to skip");
}

TEST(TextTable, NamesMissingColumnsBesideNumberedOnes) {
  ImportMap map = rate_map();
  map.axis_columns[0] = {.number = 2};
  EXPECT_EQ(text(read_rows("t,x,y\n1,2,3\n", map, "f").error()),
            "f:1:1: no column \"T\", expected one of: \"t\", \"x\", \"y\"");
  map.axis_columns[0] = {.number = 5};
  EXPECT_EQ(text(read_rows("t,x,y\n1,2,3\n", map, "f").error()),
            "f:1:1: no column \"T\", expected one of: \"t\", \"x\", \"y\"; the table has 3 columns, expected at "
            "least 5");
  EXPECT_EQ(text(read_rows("t,T,y\n1,2,3\n", map, "f").error()), "f:1:1: 3 columns, expected at least 5");
  map.thermometer_columns[0].column = {.number = 4};
  map.time = ColumnName{"time"};
  EXPECT_EQ(text(read_rows("t\n1\n", map, "f").error()),
            "f:1:1: no column \"time\", expected one of: \"t\"; the table has 1 column, expected at least 5");
}

/// Lines before the first row that have too few fields, too many, or fields that are not numbers.
TEST(TextTable, TakesLayoutFromFirstReadableRow) {
  const std::string rows = "0,20,21,1\n10,21,22,2\n20,22,23,3\n30,23,24,4\n40,24,25,5\n50,25,26,6\n";
  ImportMap map = numbered_map(4);
  map.leaves_out_damaged = true;
  const auto expected = read_rows(rows, map, "f");
  ASSERT_TRUE(expected) << text(expected.error());
  for (const char* damage : {"STOPPED\n12\n", "STOPPED\n", "1\n2\n3\n", "1,2\n1,2\n", "1,2,3\n4,5,6\n", "a,b,c,d,e\n",
                             "1,2,3,x\n", "1,2,3,x,5\n", "\"\n", "x\n\"\n1,2\n", "999999999999999999,1,1,x\n"}) {
    SCOPED_TRACE(damage);
    const auto read = read_rows(damage + rows, map, "f");
    ASSERT_TRUE(read) << text(read.error());
    EXPECT_EQ(read->time, expected->time);
    EXPECT_EQ(read->columns, expected->columns);
    EXPECT_EQ(read->notes.size(), 1u);
  }
  EXPECT_EQ(text(read_rows("STOPPED\n12\n", map, "f").error()), "f:1:1: 1 column, expected at least 4");
}

/// Random lines from few characters, before and between good rows, with every kind of time.
TEST(TextTable, SurvivesRandomDamageWithoutHeader) {
  std::mt19937 random(20261130);
  constexpr std::string_view kCharacters = "0123456789,,,,.:x \"-";
  std::size_t read_files = 0;
  for (int file = 0; file < 2000; ++file) {
    ImportMap map = numbered_map(3);
    map.leaves_out_damaged = true;
    map.out_of_order = OutOfOrder::skip;
    map.time_form = file % 3 == 0 ? TimeForm::clock : TimeForm::number;
    if (file % 3 == 1) map.wrap = CountedTime{65};
    if (file % 5 == 0) map.time->number = 4;
    std::string bytes;
    for (unsigned row = 0; row < 12; ++row) {
      for (auto damage = random() % 2; damage > 0; --damage) {
        for (auto size = 1 + random() % 12; size > 0; --size) bytes += kCharacters[random() % kCharacters.size()];
        bytes += '\n';
      }
      const auto time = map.time_form == TimeForm::clock ? fmt::format("08:00:{:02}", row) : std::to_string(row);
      bytes += fmt::format("{},20,{},{}\n", time, row, time);
    }
    const auto rows = read_rows(bytes, map, "f");
    if (rows) ++read_files;
    if (!rows) EXPECT_EQ(rows.error().kind, FaultKind::bad_file);
  }
  EXPECT_GE(read_files, 1000u);
}

/// A line that is left out must not move the clock, whatever time it shows.
TEST(TextTable, LeavesClockUnchangedByDamagedRow) {
  struct Case {
    const char* name;
    TimeForm form;
    std::vector<std::string> times;
    std::vector<std::string> damaged;
  };
  const std::vector<Case> cases{
      {"clock", TimeForm::clock, {"08:00:00", "08:01:00", "08:02:00"}, {"23:01:00", "00:01:00", "20:00:01"}},
      {"clock over midnight", TimeForm::clock, {"23:59:00", "00:00:00", "00:01:00"}, {"12:30:00", "11:00:00"}},
      {"counter", TimeForm::number, {"0", "60000", "120000"}, {"900000", "1e30", "-1e30", "99999999999999", "1"}},
      {"ISO",
       TimeForm::civil,
       {"2026-03-01T08:00:00Z", "2026-03-01T08:01:00Z", "2026-03-01T08:02:00Z"},
       {"1999-03-01T08:00:00Z", "2099-03-01T08:00:00Z"}},
  };
  for (const auto& [name, form, times, damaged] : cases)
    for (const auto& time : damaged)
      for (std::size_t at = 0; at < times.size(); ++at) {
        SCOPED_TRACE(fmt::format("{}: {} before row {}", name, time, at));
        ImportMap map = rate_map();
        map.leaves_out_damaged = true;
        map.time_form = form;
        map.wrap = form == TimeForm::number ? std::optional(CountedTime{1000}) : std::nullopt;
        std::string bytes = "t,T,w\n";
        for (std::size_t i = 0; i < times.size(); ++i) {
          if (i == at) bytes += time + ",2#.1,3\n";
          bytes += times[i] + ",20,3\n";
        }
        const auto rows = read_rows(bytes, map, "f");
        ASSERT_TRUE(rows) << text(rows.error());
        using std::chrono::minutes;
        EXPECT_EQ(rows->time, (std::vector<Duration>{minutes(0), minutes(1), minutes(2)}));
        if (form == TimeForm::civil) EXPECT_EQ(rows->utc[0], std::chrono::seconds(1772352000));
      }
}

TEST(TextTable, RefusesTimesOverTenYears) {
  ImportMap map = rate_map();
  map.time_form = TimeForm::clock;
  std::string clocks = "t,T,w\n";
  for (int day = 0; day < 3660; ++day) clocks += "00:00,20,3\n08:00,20,3\n16:00,20,3\n";
  const auto by_clock = read_rows(clocks, map, "f");
  ASSERT_FALSE(by_clock);
  EXPECT_EQ(by_clock.error().where, "f:10959:1");
  map.time.reset();
  map.interval = std::chrono::hours(24 * 1000);
  EXPECT_EQ(read_rows("T,w\n1,2\n1,2\n1,2\n1,2\n1,2\n", map, "f").error().where, "f:6:1");
  EXPECT_TRUE(read_rows("T,w\n1,2\n1,2\n1,2\n1,2\n", map, "f"));
}

TEST(TextTable, RequiresLastColumnIfItHasTime) {
  for (const char* last : {"Comment", ""}) {
    ImportMap map = rate_map();
    map.time = *last != '\0' ? ColumnName{last} : ColumnName{.number = 3};
    const std::string header = fmt::format("T,w,{}\n", last);
    EXPECT_EQ(read_rows(header + "20,1,0\n20,1\n", map, "f").error().where, "f:3:1");
    map.time = ColumnName{"T"};
    EXPECT_TRUE(read_rows(header + "20,1,0\n21,1\n", map, "f"));
  }
}

TEST(TextTable, IncrementCoversTimeSinceRowBefore) {
  ImportMap map = rate_map();
  map.units[0].axes[0].kind = GyroKind::pulse_count;
  using std::chrono::milliseconds;
  const auto rows = read_rows("t,T,w\n0,2,3\n10,2,3\n20,2,3\n500,2,3\n", map, "f").value();
  EXPECT_EQ(rows.interval,
            (std::vector<Duration>{milliseconds(10), milliseconds(10), milliseconds(10), milliseconds(480)}));
}

TEST(TextTable, NamesMissingAndExistingColumns) {
  EXPECT_EQ(text(read_rows("time,\"T [°C]\",rate\n1,2,3\n", rate_map(), "f").error()),
            "f:1:1: no columns \"t\", \"T\", \"w\", expected one of: \"time\", \"T [°C]\", \"rate\"");
  std::string wide = "t";
  for (int i = 0; i < 100; ++i) wide += ",c" + std::to_string(i);
  const auto said = text(read_rows(wide + "\n", rate_map(), "f").error());
  EXPECT_NE(said.find("\"c58\" and 41 more"), std::string::npos) << said;
}

TEST(TextTable, TreatsMarkersAsMissingValues) {
  ImportMap map = rate_map();
  map.missing = {"", "NaN", "-999"};
  const auto rows = read_rows("t,T,w\n0,NaN,3\n1,,-999\n2,20, NaN \n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_TRUE(std::isnan(rows->columns[0][0]) && std::isnan(rows->columns[0][1]));
  EXPECT_EQ(rows->columns[0][2], 20);
  EXPECT_EQ(rows->columns[1][0], 3);
  EXPECT_TRUE(std::isnan(rows->columns[1][1]) && std::isnan(rows->columns[1][2]));
  EXPECT_EQ(text(read_rows("t,T,w\n,1,2\n", map, "f").error()), "f:2:1: \"\" in column \"t\", expected a number")
      << "a row without a time is none, and missing = [\"\"] does not help it";
  map.missing = {"ü", "a \"b\""};
  EXPECT_TRUE(read_rows("t,T,w\n0,\xFC,ü\n1,\"a \"\"b\"\"\",2\n", map, "f")) << "in Latin-1, with quotes";
}

TEST(TextTable, IgnoresBlanksAroundMarkersOfMissingValues) {
  ImportMap map = rate_map();
  map.cell_units = {"°C", "C", ""};
  for (const char* marker : {" °C", "°C", " °C\t", " ", "", "\t C", " - ", "C", "-999 °C"}) {
    SCOPED_TRACE(marker);
    map.missing = {marker};
    const auto rows = read_rows(fmt::format("t,T,w\n0,20 °C,1\n1,{},2\n2,\"{}\",3\n", marker, marker), map, "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_TRUE(rows->columns[0][0] == 20 && std::isnan(rows->columns[0][1]) && std::isnan(rows->columns[0][2]));
  }
  map.missing.clear();
  for (const char* field : {"\" °C\"", " °C ", "\"\t°C\"", "\"  C\""})
    EXPECT_EQ(read_rows(fmt::format("t,T,w\n0,20,1\n1,{},2\n", field), map, "f").error().where.rfind("f:3:", 0), 0u)
        << field;
}

TEST(TextTable, SuggestsDecimalCommaWhenMapCanHaveIt) {
  ImportMap map = rate_map();
  map.separator = ';';
  EXPECT_EQ(text(read_rows("t;T;w\n1;2,5;3\n", map, "f").error()),
            "f:2:3: \"2,5\" in column \"T\", expected a number with a decimal point, or decimal = \",\" in [file]");
}

TEST(TextTable, AcceptsBlanksAroundQuotes) {
  const auto rows = read_rows("\"t\", \"T\" ,\t\"w\"\n\"0\", \"20\", \"1\"\n", rate_map(), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], std::vector<double>{1});
  ImportMap map = rate_map();
  map.separator = ' ';
  map.time->name = "Time s";
  map.thermometer_columns[0].column.name = "T \"1\"";
  const auto apart = read_rows(" \"Time s\"  \"T \"\"1\"\"\"\t\"w\"\n0 \"20\" 1\n", map, "f");
  ASSERT_TRUE(apart) << text(apart.error());
  EXPECT_EQ(apart->columns[0], std::vector<double>{20});
  EXPECT_EQ(text(read_rows("\"t\"x T w\n", map, "f").error()),
            "f:1:4: text after a closing quote, expected a separator");
  EXPECT_EQ(text(read_rows("t \"T w\n", map, "f").error()),
            "f:1:3: a quote is not closed, expected \" before the end of the line");
  map.separator = '\t';
  map.time->name = "t";
  map.thermometer_columns[0].column.name = "";
  EXPECT_TRUE(read_rows("t\t\t\"w\"\n0\t1\t2\n", map, "f")) << "a separating tab is not a blank before a quote";
}

TEST(TextTable, SkipCountsLinesOfFile) {
  ImportMap map = numbered_map(3);
  map.skip = 3;
  const auto rows = read_rows("Logger v1\n\nSerial 5\n0,20,1\n1,20,2\n2,20,3\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{1, 2, 3}));
}

TEST(TextTable, AcceptsDecimalComma) {
  ImportMap map = rate_map();
  map.separator = ';';
  map.decimal = ',';
  const auto rows = read_rows("t;T;w\n0;20,5;-1,25e1\n1;21;3\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[0], (std::vector<double>{20.5, 21}));
  EXPECT_EQ(rows->columns[1], (std::vector<double>{-12.5, 3}));
  EXPECT_EQ(text(read_rows("t;T;w\n0;20.5;1\n", map, "f").error()),
            "f:2:3: \"20.5\" in column \"T\", expected a number with a decimal comma");
}

TEST(TextTable, RequiresZoneOfCalendarTimes) {
  ImportMap map = rate_map();
  map.time_form = TimeForm::civil;
  const std::string table = "t,T,w\n2026-03-01T12:00:00{0},20,3\n2026-03-01T12:00:02.5{0},21,4\n";
  const auto with = [&](const std::string& zone) {
    std::string text = table;
    for (std::size_t at; (at = text.find("{0}")) != std::string::npos;) text.replace(at, 3, zone);
    return read_rows(text, map, "f");
  };
  const auto rows = with("+01:00");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->time[1], std::chrono::milliseconds(2500));
  EXPECT_EQ(rows->utc[0], std::chrono::seconds(1772362800)) << "11:00:00 UTC";
  EXPECT_EQ(text(with("").error()),
            "f:2:1: \"2026-03-01T12:00:00\" has no zone, expected one after the time, or zone = \"Z\" in [time]");
  map.zone = std::chrono::hours(-5);
  EXPECT_EQ(with("")->utc[0], std::chrono::seconds(1772362800 + 6 * 3600));
  EXPECT_EQ(with("Z")->utc[0], std::chrono::seconds(1772362800 + 3600)) << "the zone in the text applies";
  EXPECT_EQ(text(read_rows("t,T,w\n01.03.2026 12:00,1,2\n", map, "f").error()),
            "f:2:1: \"01.03.2026 12:00\", expected a time like \"2026-03-01T12:30:05.25Z\"");
}

TEST(TextTable, CountsTimeFromInstant) {
  ImportMap map = rate_map();
  map.since = CountedTime{};
  const auto rows = read_rows("t,T,w\n1772362800000,20,3\n1772362801000,20,3\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->utc[1], std::chrono::seconds(1772362801));
  EXPECT_EQ(rows->time[1], std::chrono::seconds(1));
  EXPECT_FALSE(read_rows("t,T,w\n1e18,20,3\n", map, "f")) << "in milliseconds that is not this side of 2116";
}

TEST(TextTable, KeepsAllDigitsOfTimes) {
  ImportMap map = rate_map();
  map.since = CountedTime{};
  const auto times_of = [&](const std::string& column, Duration unit) {
    map.time_unit = unit;
    const auto rows = read_rows("t,T,w\n" + column, map, "f");
    EXPECT_TRUE(rows) << text(rows.error());
    for (std::size_t i = 0; i < rows->time.size(); ++i) EXPECT_EQ(*rows->utc[i], *rows->utc[0] + rows->time[i]);
    return rows->time;
  };
  using std::chrono::milliseconds;
  EXPECT_EQ(times_of("1767225600000000000,1,2\n1767225600001000000,1,2\n1767225600001000100,1,2\n", Duration(1)),
            (std::vector<Duration>{{}, milliseconds(1), Duration(1'000'100)}));
  EXPECT_EQ(times_of("1767225600.00,1,2\n1767225600.29,1,2\n1767225600.30,1,2\n1767225600.300001,1,2\n", kSecond),
            (std::vector<Duration>{{}, milliseconds(290), milliseconds(300), Duration(300'001'000)}));
}

TEST(TextTable, IgnoresSeparatorLineOfSpreadsheets) {
  ImportMap map = rate_map();
  map.separator = ';';
  const auto rows = read_rows("\xEF\xBB\xBFsep=;\r\nt;T;w\r\n0;1;2\r\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], std::vector<double>{2});
  map = numbered_map(3);
  map.separator = ';';
  for (const std::size_t skip : {0U, 1U}) {
    map.skip = skip;
    const auto numbered = read_rows("sep=;\n0;20;1\n1;20;1\n", map, "f");
    ASSERT_TRUE(numbered) << text(numbered.error());
    EXPECT_EQ(numbered->time.size(), 2u) << "it is not a row in either case";
  }
}

TEST(TextTable, ReadsLatin1Header) {
  ImportMap map = rate_map();
  map.thermometer_columns[0].column.name = "T [°C]";
  EXPECT_TRUE(
      read_rows("t,T [\xB0"
                "C],w\n0,1,2\n",
                map, "f"));
  EXPECT_TRUE(read_rows("t,T [°C],w\n0,1,2\n", map, "f"));
}

TEST(TextTable, LeavesOutRowsOutOfOrder) {
  ImportMap map = rate_map();
  map.out_of_order = OutOfOrder::skip;
  const auto rows = read_rows("t,T,w\n0,1,2\n10,1,3\n5,1,4\n10,1,5\n20,1,6\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{2, 4, 5, 6}));
  EXPECT_EQ(rows->notes, Notes{"1 row was left out because its time was not after the previous row's"});
}

}  // namespace
}  // namespace gyrotherm::exchange
