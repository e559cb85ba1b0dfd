// SPDX-License-Identifier: Apache-2.0
/// Imports files in the notations of other programs. Each becomes a record, or is refused with one message that gives
/// the solution.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "acquisition/record/record.hpp"
#include "tests/acquisition/exchange/foreign.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

/// Returns the map of a table with a time t, a thermometer T and a rate w, with the given keys in [file] and [time].
std::string table_map(const std::string& file_keys, const std::string& time_keys = "column = \"t\"\nunit = \"s\"",
                      const std::string& thermometer = "T", const std::string& rate = "w") {
  return "schema = \"gyrotherm-import/1\"\nname = \"foreign\"\n[file]\n" + file_keys + "\n[time]\n" + time_keys +
         "\n[[thermometer]]\nname = \"oven wall\"\ncolumn = \"" + thermometer + "\"\n[gyro]\ncolumn = \"" + rate +
         "\"\nkind = \"rate\"\nscale = 3600\n";
}

std::string in_utf16(const std::string& ascii) {
  std::string wide = "\xFF\xFE";
  for (const char c : ascii) wide += {c, '\0'};
  return wide;
}

std::string rows_at(int per_second, int rows) {
  std::string table = "t,T,w\n";
  for (int i = 0; i < rows; ++i)
    table += std::to_string(static_cast<double>(i) / per_second) + ",20.5," + std::to_string(i / per_second) + "\n";
  return table;
}

std::string px4_log() {
  UlogText log;
  log.format("sensor_gyro:uint64_t timestamp;float x;").format("sensor_baro:uint64_t timestamp;float temperature;");
  log.subscribe(0, "sensor_gyro").subscribe(1, "sensor_baro");
  for (unsigned i = 0; i < 1000; ++i) {
    log.data(0, little(std::uint64_t{4000} * i) + little(0.25F));
    if (i % 25 == 0) log.data(1, little(std::uint64_t{4000} * i) + little(20.5F));
  }
  return log.text();
}

std::string ardupilot_log() {
  DataflashText log;
  log.format(9, "IMU", "Qff", "TimeUS,GyrX,T", 19);
  for (unsigned i = 0; i < 100; ++i) log.message(9, little(std::uint64_t{40'000} * i) + little(0.25F) + little(20.5F));
  return log.text();
}

struct ForeignFile {
  std::string name, map, bytes;
  /// The number of rows in the record.
  std::size_t rows{};
  /// The reason of a refusal, after the name of the file.
  std::string message{};
};

std::vector<ForeignFile> foreign_files() {
  const std::string good = "t,T,w\n0,20.5,0.25\n1,20.5,0.25\n2,20.5,0.25\n";
  const std::string iso = "column = \"t\"\nunit = \"iso\"", every = "column = \"t\"\nunit = \"s\"\nevery = \"1 s\"";
  const auto log_map = [&](const std::string& format, const std::string& thermometer, const std::string& rate) {
    return table_map("format = \"" + format + "\"", "every = \"1 s\"", thermometer, rate);
  };
  return {
      {"plain", table_map(""), good, 3},
      {"semicolons and decimal commas", table_map("separator = \";\"\ndecimal = \",\""),
       "t;T;w\n0;20,5;0,25\n1;20,5;0,25\n", 2},
      {"a table of a spreadsheet", table_map("separator = \";\"\ndecimal = \",\""),
       "\xEF\xBB\xBFsep=;\r\nt;T;w\r\n0;\"20,5\";0,25\r\n", 1},
      {"tabulators", table_map("separator = \"\\t\""), "t\tT\tw\n0\t20.5\t0.25\n", 1},
      {"blanks and comments", table_map("separator = \" \"\ncomment = \"%\""), "% a rig\n  t   T  w\n 0  20.5 0.25\n",
       1},
      {"UTF-16", table_map(""), in_utf16(good), 3},
      {"UTF-16 without its mark", table_map(""), in_utf16(good).substr(2), 0,
       ":1:1: a NUL byte, expected UTF-8, or UTF-16 with a byte order mark"},
      {"UTF-8 with a mark", table_map(""), "\xEF\xBB\xBF" + good, 3},
      {"Latin-1 in the header", table_map("", "column = \"t\"\nunit = \"s\"", "T [°C]"),
       "t,T [\xB0"
       "C],w\n0,20.5,0.25\n",
       1},
      {"missing values", table_map("missing = [\"\", \"NaN\"]"), "t,T,w\n0,20.5,0.25\n1,NaN,0.25\n2,20.5,\n", 3},
      {"missing values of which the map says nothing", table_map(""), "t,T,w\n0,20.5,0.25\n1,NaN,0.25\n", 0,
       ":3:3: \"NaN\" in column \"T\", expected a number, or missing = [\"NaN\"] in [file]"},
      {"gaps", table_map(""), "t,T,w\n0,20.5,0.25\n1,20.5,0.25\n2,20.5,0.25\n600,20.5,0.25\n", 4},
      {"times with a zone", table_map("", iso),
       "t,T,w\n2026-03-29T01:59:59+01:00,20.5,0.25\n2026-03-29T03:00:00+02:00,20.5,0.25\n", 2},
      {"a leap second", table_map("", iso),
       "t,T,w\n2016-12-31T23:59:59Z,20.5,0.25\n2016-12-31T23:59:60Z,20.5,0.25\n2017-01-01T00:00:00Z,20.5,0.25\n", 0,
       ":4:1: the time does not increase (a leap second, 23:59:60, counts as 00:00:00), expected one after the row "
       "before, or out_of_order = \"skip\" in [time]"},
      {"a leap second that is left out", table_map("", iso + "\nout_of_order = \"skip\""),
       "t,T,w\n2016-12-31T23:59:60Z,20.5,0.25\n2017-01-01T00:00:00Z,20.5,0.25\n2017-01-01T00:00:01Z,20.5,0.25\n", 2},
      {"times of a day that has none", table_map("", iso),
       "t,T,w\n2026-03-01T00:00:00Z,20.5,0.25\n2026-03-01T00:00:00Z,20.5,0.25\n", 0,
       ":3:1: the time does not increase, expected one after the row before, or out_of_order = \"skip\" in [time]"},
      {"times without a zone", table_map("", iso), "t,T,w\n2026-03-29T01:59:59,20.5,0.25\n", 0,
       ":2:1: \"2026-03-29T01:59:59\" has no zone, expected one after the time, or zone = \"Z\" in [time]"},
      {"time that goes back", table_map(""), "t,T,w\n0,20.5,0.25\n5,20.5,0.25\n4,20.5,0.25\n", 0,
       ":4:1: the time goes back 1 s, expected one after the row before, or out_of_order = \"skip\" in [time]"},
      {"time that goes back, and is allowed to", table_map("", every + "\nout_of_order = \"skip\""),
       "t,T,w\n0,20.5,0.25\n5,20.5,0.25\n4,20.5,0.25\n", 2},
      {"a hundred rows a second", table_map(""), rows_at(100, 300), 300},
      {"a hundred rows a second, put together", table_map("", every), rows_at(100, 300), 3},
      {"many rows", table_map("", every), rows_at(10, 200'000), 20'000},
      {"another column's name", table_map("", "column = \"t\"\nunit = \"s\"", "T", "omega"), good, 0,
       ":1:1: no column \"omega\", expected one of: \"t\", \"T\", \"w\""},
      {"a header alone", table_map(""), "t,T,w\n", 0, ":1:1: the file ends, expected at least one row"},
      {"a row that is cut off", table_map(""), good + "3,20", 0,
       ":5:1: 2 fields, expected 3, or damaged = \"skip\" in [file]"},
      {"decimal commas of which the map says nothing", table_map("separator = \";\""), "t;T;w\n0;20,5;0,25\n", 0,
       ":2:3: \"20,5\" in column \"T\", expected a number with a decimal point, or decimal = \",\" in [file]"},
      {"a log of PX4", log_map("ulog", "sensor_baro.temperature", "sensor_gyro.x"), px4_log(), 4},
      {"a log of PX4 that is cut off", log_map("ulog", "sensor_baro.temperature", "sensor_gyro.x"),
       px4_log().substr(0, 12'000), 3},
      {"a log of PX4 by a table's map", table_map(""), px4_log(), 0,
       ": the file is ulog, the map reads text; expected format = \"ulog\" in [file]"},
      {"a log of ArduPilot", log_map("dataflash", "IMU.T", "IMU.GyrX"), ardupilot_log(), 4},
      {"a log of ArduPilot without that message", log_map("dataflash", "IMU.T", "IMU2.GyrX"), ardupilot_log(), 0,
       ": no column \"IMU2.GyrX\", expected one of: \"IMU\""},
      {"a NetCDF file by a table's map", table_map(""), "\x89HDF\r\n\x1A\n", 0,
       ": the file is netcdf, the map reads text; expected format = \"netcdf\" in [file]"},
      {"what is no NetCDF file", table_map("format = \"netcdf\"", ""), good, 0,
       ": cannot be read as NetCDF or HDF5: NetCDF: Unknown file format"},
      {"an empty file", table_map(""), "", 0, ":1:1: the file ends, expected a header"},
      {"a picture", table_map(""), std::string("\x89PNG\r\n\x1A\n\0\0\0\rIHDR", 16), 0,
       ":1:1: no columns \"t\", \"T\", \"w\", expected one of: \"\\u0089PNG\""},
  };
}

TEST(ForeignFiles, AreImportedOrRefusedWithUsefulMessage) {
  const tests::TestFolder folder;
  const auto files = foreign_files();
  EXPECT_GE(files.size(), 20u);
  for (const ForeignFile& file : files) {
    SCOPED_TRACE(file.name);
    const std::string path = folder / "file", map = folder / "map.toml", out = folder / "run.db";
    std::ofstream(path, std::ios::binary) << file.bytes;
    std::ofstream(map) << file.map;
    const auto summary = import_record(path, map, out, "0.1.0");
    if (!file.message.empty()) {
      ASSERT_FALSE(summary);
      EXPECT_EQ(text(summary.error()), path + file.message);
      EXPECT_FALSE(std::filesystem::exists(out));
      continue;
    }
    ASSERT_TRUE(summary) << text(summary.error());
    const auto made = record::read_record(out);
    ASSERT_TRUE(made) << text(made.error());
    EXPECT_EQ(made->slot.size(), file.rows);
    EXPECT_EQ(made->info.thermometers[0].name, "oven wall");
    EXPECT_EQ(made->thermometers_c[0][0], 20.5);
    std::filesystem::remove(out);
    std::filesystem::remove(out + ".sha256");
  }
}

TEST(ForeignFiles, ReportSkippedContentInRecord) {
  const tests::TestFolder folder;
  std::ofstream(folder / "file", std::ios::binary) << px4_log().substr(0, 12'000);
  std::ofstream(folder / "map.toml") << table_map("format = \"ulog\"", "every = \"1 s\"", "sensor_baro.temperature",
                                                  "sensor_gyro.x");
  const auto summary = import_record(folder / "file", folder / "map.toml", folder / "run.db", "0.1.0");
  ASSERT_TRUE(summary) << text(summary.error());
  ASSERT_EQ(summary->notes.size(), 3u) << "the end, and two constant channels";
  const auto made = record::read_record(folder / "run.db").value();
  ASSERT_EQ(made.events.size(), summary->notes.size() + 1) << "and the values of the channels";
  EXPECT_EQ(made.events[0].event.text, summary->notes[0]);
  EXPECT_EQ(made.events[0].event.text.rfind("the log ends within a message", 0), 0u);
  EXPECT_EQ(made.events.back().event.text.rfind("values of the file: oven wall: ", 0), 0u);
}

}  // namespace
}  // namespace gyrotherm::exchange
