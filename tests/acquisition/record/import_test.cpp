// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/import.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "acquisition/record/status.hpp"
#include "tests/acquisition/record/runs.hpp"

namespace gyrotherm::record {
namespace {

const std::string kMap = R"(schema = "gyrotherm-import/1"
name = "bench"
[file]
separator = ";"
comment = "#"
skip = 1
[time]
column = "t"
unit = "ms"
[[thermometer]]
name = "die"
column = "T"
scale = 0.5
offset = -1
[gyro]
column = "w"
kind = "rate"
scale = 219.5
[analysis]
gradients = ["die"]
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(ImportMap, IsReadAsItIsWritten) {
  const auto map = parse_import_map(kMap, "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(map->separator, ';');
  EXPECT_EQ(map->comment, "#");
  EXPECT_TRUE(map->header);
  EXPECT_EQ(map->skip, 1u);
  EXPECT_EQ(map->time->name, "t");
  EXPECT_EQ(map->time_unit, std::chrono::milliseconds(1));
  ASSERT_EQ(map->thermometers.size(), 1u);
  EXPECT_EQ(map->thermometer_columns[0].scale, 0.5);
  EXPECT_EQ(map->thermometer_columns[0].offset, -1);
  EXPECT_EQ(map->units[0].axes[0].kind, GyroKind::rate);
  EXPECT_EQ(map->units[0].axes[0].scale, 219.5);
  EXPECT_FALSE(map->units[0].axes[0].earth_rate);
  EXPECT_EQ(map->units[0].gradients, std::vector<std::string>{"die"});
  EXPECT_EQ(map->text, kMap);
}

TEST(ImportMap, ColumnsOfAFileWithoutAHeaderAreNumbers) {
  std::string numbered = replaced(kMap, "comment = \"#\"", "header = false");
  for (const char* name : {"\"t\"", "\"T\"", "\"w\""}) numbered = replaced(numbered, name, "2");
  const auto map = parse_import_map(numbered, "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(map->axis_columns[0].number, 2u);
  EXPECT_FALSE(parse_import_map(replaced(kMap, "comment = \"#\"", "header = false"), "map.toml"));
}

TEST(ImportMap, EveryMistakeIsNamedWithItsPlace) {
  struct Case {
    const char* from;
    const char* to;
    const char* place;
  };
  for (const Case& mistake : {
           Case{"gyrotherm-import/1", "gyrotherm-import/2", "map.toml:1:"},
           Case{"separator = \";\"", "separator = \"|\"", "map.toml:4:"},
           Case{"skip = 1", "skip = -1", "map.toml:6:"},
           Case{"unit = \"ms\"", "unit = \"min\"", "map.toml:9:"},
           Case{"column = \"t\"\nunit = \"ms\"", "interval = \"0 s\"", "map.toml:8:"},
           Case{"name = \"die\"", "name = \"slot\"", "map.toml:10:"},
           Case{"scale = 0.5", "scale = 0", "map.toml:13:"},
           Case{"kind = \"rate\"", "kind = \"angle\"", "map.toml:17:"},
           Case{"gradients = [\"die\"]", "gradients = [\"dye\"]", "map.toml:20:"},
           Case{"name = \"bench\"", "name = \"bench\"\nnonsense = 1", "map.toml:3:"},
           Case{"[file]", "[file", "map.toml:3:"},
       }) {
    const auto map = parse_import_map(replaced(kMap, mistake.from, mistake.to), "map.toml");
    ASSERT_FALSE(map) << mistake.to;
    EXPECT_EQ(map.error().kind, FaultKind::bad_file);
    EXPECT_EQ(map.error().where.rfind(mistake.place, 0), 0u) << mistake.to << " → " << text(map.error());
  }
}

TEST(ImportMap, EveryShippedMapIsGood) {
  int maps = 0;
  for (const auto& file : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/imports")) {
    const auto map = load_import_map(file.path());
    EXPECT_TRUE(map) << text(map.error());
    ++maps;
  }
  EXPECT_GE(maps, 4);
}

TEST(ImportMap, MissingFileIsABadFile) {
  EXPECT_EQ(load_import_map("/nowhere/map.toml").error().kind, FaultKind::bad_file);
}

}  // namespace

namespace {

ImportMap rate_map() {
  ImportMap map;
  map.name = "bench";
  map.text = "the map";
  map.time = ColumnName{"t"};
  map.time_unit = std::chrono::milliseconds(1);
  map.thermometers = {"die"};
  map.thermometer_columns = {{{"T"}, 0.5, -1}};
  map.units = {{.axes = {{.kind = GyroKind::rate, .scale = 219.5}}}};
  map.axis_columns = {{"w"}};
  return map;
}

TEST(Import, ReadsColumnsByNameWhateverTheirOrder) {
  const auto rows = parse_foreign_rows("w,x,T,t\n7,?,20,1000\n-8.5,,1e1,1500\n", rate_map(), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->time, (std::vector<Duration>{{}, std::chrono::milliseconds(500)}));
  EXPECT_EQ(rows->thermometers_c[0], (std::vector<double>{9, 4}));
  EXPECT_EQ(rows->rotation[0], (std::vector<double>{7, -8.5}));
}

TEST(Import, BearsCrLfByteOrderMarkBlanksQuotesCommentsAndEmptyLines) {
  ImportMap map = rate_map();
  map.comment = "%";
  const std::string bytes = "\xEF\xBB\xBF% made by hand\r\n\"T \", t ,w\r\n\r\n\"20\", 0 ,+1\r\n% pause\r\n21,1,2";
  const auto rows = parse_foreign_rows(bytes, map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->rotation[0], (std::vector<double>{1, 2}));
  EXPECT_EQ(rows->thermometers_c[0], (std::vector<double>{9, 9.5}));
}

TEST(Import, TakesAnyRunOfBlanksAsOneSeparatorAndSkipsLeadingLines) {
  ImportMap map;
  map.separator = ' ';
  map.header = false;
  map.skip = 2;
  map.interval = std::chrono::milliseconds(10);
  map.axis_columns = {{.number = 3}};
  const auto rows = parse_foreign_rows("a b\nc\n 1  2 3 \n4\t5 6\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->rotation[0], (std::vector<double>{3, 6}));
  EXPECT_EQ(rows->time[1], std::chrono::milliseconds(10));
  EXPECT_EQ(rows->interval[1], std::chrono::milliseconds(10));
}

TEST(Import, NamesThePlaceOfEveryKindOfBadInput) {
  struct Case {
    const char* bytes;
    const char* said;
  };
  for (const Case& bad : {
           Case{"", "f:0:1: the file ends, expected a header"},
           Case{"t,T,w\n", "f:1:1: the file ends, expected at least one row"},
           Case{"t,T\n1,2\n", "f:1:1: no column \"w\" in the header"},
           Case{"t,T,w,T \n1,2,3,4\n", "f:1:7: a second column \"T\", expected one"},
           Case{"t,T,w\n1,2\n", "f:2:1: 2 fields, expected 3"},
           Case{"t,T,w\n1,2,3,4\n", "f:2:1: 4 fields, expected 3"},
           Case{"t,T,w\n1,2,3\n2,nan,3\n", "f:3:3: \"nan\", expected a number"},
           Case{"t,T,w\n1,2,inf\n", "f:2:5: \"inf\", expected a number"},
           Case{"t,T,w\n1,2,1e999\n", "f:2:5: \"1e999\", expected a number"},
           Case{"t,T,w\n1,,3\n", "f:2:3: \"\", expected a number"},
           Case{"t,T,w\n1,2,3x\n", "f:2:5: \"3x\", expected a number"},
           Case{"t,T,w\n1,2,0x10\n", "f:2:5: \"0x10\", expected a number"},
           Case{"t,T,w\n1,\"2,5\",3\n", "f:2:3: \"2,5\", expected a number with a decimal point"},
           Case{"t,T,w\n1,\"2,3\n", "f:2:3: a quote is not closed, expected \" before the end of the line"},
           Case{"t,T,w\n1,\"2\"5,3\n", "f:2:6: text after a closing quote, expected a separator"},
           Case{"t,T,w\n5,2,3\n5,2,3\n", "f:3:1: the time does not increase, expected one after the row before"},
           Case{"t,T,w\n5,2,3\n4,2,3\n", "f:3:1: the time does not increase, expected one after the row before"},
           Case{"t,T,w\n0,2,3\n1e15,2,3\n", "f:3:1: more than ten years after the first row"},
       }) {
    const auto rows = parse_foreign_rows(bad.bytes, rate_map(), "f");
    ASSERT_FALSE(rows) << bad.bytes;
    EXPECT_EQ(rows.error().kind, FaultKind::bad_file);
    EXPECT_EQ(text(rows.error()), bad.said);
  }
}

TEST(Import, BoundsALineAndItsFieldsWithItsNumber) {
  const std::string header = "t,T,w\n", row = "1,2,3\n";
  const auto said = [&](const std::string& bytes) {
    const auto rows = parse_foreign_rows(bytes, rate_map(), "f");
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
  EXPECT_EQ(text(parse_foreign_rows(wide + "\n", blanks, "f").error()),
            "f:1:8193: more than 4096 fields, expected fewer");
}

TEST(Import, NamesAColumnNumberThatTheFileLacks) {
  ImportMap map = rate_map();
  map.header = false;
  map.time->number = 1;
  map.thermometer_columns[0].column.number = 2;
  map.axis_columns[0].number = 4;
  EXPECT_EQ(text(parse_foreign_rows("1,2,3\n", map, "f").error()), "f:1:1: 3 columns, expected at least 4");
  map.skip = 2;
  EXPECT_EQ(text(parse_foreign_rows("1,2,3\n", map, "f").error()), "f:1:1: the file ends among the lines to skip");
}

TEST(Import, IncrementCoversTheTimeSinceTheRowBefore) {
  ImportMap map = rate_map();
  map.units[0].axes[0].kind = GyroKind::pulse_count;
  using std::chrono::milliseconds;
  const auto rows = parse_foreign_rows("t,T,w\n0,2,3\n10,2,3\n20,2,3\n500,2,3\n", map, "f").value();
  EXPECT_EQ(rows.interval,
            (std::vector<Duration>{milliseconds(10), milliseconds(10), milliseconds(10), milliseconds(480)}));
}

TEST(Import, FindsWhereRowsAreMissing) {
  using std::chrono::milliseconds;
  std::vector<Duration> time;
  for (const int ms : {0, 10, 20, 120, 130, 140, 250, 260}) time.push_back(milliseconds(ms));
  const Silences silences = find_silences(time);
  EXPECT_EQ(silences.median, milliseconds(10));
  EXPECT_EQ(silences.count, 1u) << "ten times the median is not more than ten times";
  EXPECT_EQ(silences.first_after, 5u);
  EXPECT_EQ(silences.total, milliseconds(110));
  EXPECT_EQ(find_silences({}).count, 0u);
  EXPECT_EQ(find_silences({Duration{}}).count, 0u);
}

const char* const kSmallMap = R"(schema = "gyrotherm-import/1"
name = "small"
[time]
column = "t"
unit = "s"
[[thermometer]]
name = "die"
column = "T"
[gyro]
column = "w"
kind = "rate"
scale = 2
earth_rate = 8.4
)";

TEST(Import, MakesAFinishedRecordThatTellsItIsForeign) {
  const Folder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  std::ofstream(folder / "small.csv") << "t,T,w\n100,20,1.25\n101,21,1.5\n102,22,1\n130,23,1\n";
  const auto summary = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_TRUE(summary) << text(summary.error());
  EXPECT_EQ(summary->rows, 4u);
  EXPECT_EQ(summary->span, std::chrono::seconds(30));
  EXPECT_EQ(summary->silences, 1u);
  const Record record = read_record(folder / "run.db").value();
  EXPECT_TRUE(record.finished && record.info.imported && !record.info.simulated);
  EXPECT_EQ(record.info.id.size(), 32u);
  EXPECT_EQ(record.info.rig_text, kSmallMap);
  EXPECT_EQ(record.info.units[0].axes[0].earth_rate, DegreesPerHour{8.4});
  EXPECT_EQ(record.slot, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_EQ(record.time_s, (std::vector<double>{0, 1, 2, 30}));
  EXPECT_EQ(record.units[0].rotation[0], (std::vector<double>{1.25, 1.5, 1, 1})) << "stored as it is in the file";
  EXPECT_EQ(record.units[0].interval_s, (std::vector<double>{1, 1, 1, 1}));
  EXPECT_TRUE(std::isnan(record.set_point_c[0]) && std::isnan(record.chamber_air_c[0]));
  ASSERT_EQ(record.events.size(), 1u);
  EXPECT_EQ(record.events[0].slot, 2);
  EXPECT_EQ(record.events[0].event.text,
            "1 gaps longer than 10 times the median spacing of 1 s, 28 s in all; the first, of 28 s, after row 2");
  EXPECT_TRUE(read_status(folder / "run.db")->finished);
}

TEST(Import, LeavesNothingBehindWhenItFails) {
  const Folder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  std::ofstream(folder / "small.csv") << "t,T,w\n100,20,1.25\n101,x,1.5\n";
  const auto bad = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().where, folder / "small.csv" + ":3:5");
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db"));
  EXPECT_EQ(import_record(folder / "none.csv", folder / "small.toml", folder / "run.db", "0.1.0").error().kind,
            FaultKind::bad_file);
}

TEST(Import, NeverOverwritesARecord) {
  const Folder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  std::ofstream(folder / "small.csv") << "t,T,w\n1,2,3\n";
  ASSERT_TRUE(import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0"));
  const auto again = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, FaultKind::storage);
  EXPECT_TRUE(read_record(folder / "run.db"));
}

}  // namespace

}  // namespace gyrotherm::record
