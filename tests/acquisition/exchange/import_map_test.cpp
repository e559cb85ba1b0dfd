// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import_map.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "core/file.hpp"

namespace gyrotherm::exchange {
namespace {

using record::GyroKind;

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

std::string replace_once(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string text_of(const Fault& fault) { return text(fault); }

TEST(ImportMap, ParsesExample) {
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

TEST(ImportMap, NumbersColumnsWithoutHeader) {
  std::string numbered = replace_once(kMap, "comment = \"#\"", "header = false");
  for (const auto& [name, number] : {std::pair{"\"t\"", "1"}, {"\"T\"", "3"}, {"\"w\"", "2"}})
    numbered = replace_once(numbered, name, number);
  const auto map = parse_import_map(numbered, "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(map->axis_columns[0].number, 2u);
  EXPECT_FALSE(parse_import_map(replace_once(kMap, "comment = \"#\"", "header = false"), "map.toml"));
}

TEST(ImportMap, ReportsEveryErrorWithPosition) {
  struct Case {
    const char* from;
    const char* to;
    const char* place;
  };
  for (const Case& mistake : {
           Case{"gyrotherm-import/1", "gyrotherm-import/2", "map.toml:1:"},
           Case{"separator = \";\"", "separator = \"|\"", "map.toml:4:"},
           Case{"skip = 1", "skip = -1", "map.toml:6:"},
           Case{"unit = \"ms\"", "unit = \"weeks\"", "map.toml:9:"},
           Case{"column = \"t\"\nunit = \"ms\"", "interval = \"0 s\"", "map.toml:8:"},
           Case{"name = \"die\"", "name = \"slot\"", "map.toml:11:"},
           Case{"scale = 0.5", "scale = 0", "map.toml:13:"},
           Case{"kind = \"rate\"", "kind = \"angle\"", "map.toml:17:"},
           Case{"separator = \";\"", "separator = \",\"\ndecimal = \",\"", "map.toml:5:"},
           Case{"separator = \";\"", "decimal = \";\"", "map.toml:4:"},
           Case{"skip = 1", "skip = 1\nformat = \"excel\"", "map.toml:7:"},
           Case{"skip = 1", "skip = 1\nformat = \"ulog\"", "map.toml:4:"},
           Case{"unit = \"ms\"", "unit = \"ms\"\nsince = \"yesterday\"", "map.toml:10:"},
           Case{"unit = \"ms\"", "unit = \"iso\"\nzone = \"CET\"", "map.toml:10:"},
           Case{"unit = \"ms\"", "unit = \"ms\"\nevery = \"0 s\"", "map.toml:10:"},
           Case{"unit = \"ms\"", "unit = \"ms\"\nout_of_order = \"sort\"", "map.toml:10:"},
           Case{"scale = 219.5", "scale = 0", "map.toml:18:"},
           Case{"scale = 219.5\n", "", "map.toml:15:"},
           Case{"gradients = [\"die\"]", "gradients = [\"dye\"]", "map.toml:20:"},
           Case{"name = \"bench\"", "name = \"bench\"\nnonsense = 1", "map.toml:3:"},
           Case{"[file]", "[file", "map.toml:3:"},
       }) {
    const auto map = parse_import_map(replace_once(kMap, mistake.from, mistake.to), "map.toml");
    ASSERT_FALSE(map) << mistake.to;
    EXPECT_EQ(map.error().kind, FaultKind::bad_file);
    EXPECT_EQ(map.error().where.rfind(mistake.place, 0), 0u) << mistake.to << " → " << text(map.error());
  }
}

TEST(ImportMap, RefusesTwoThermometersOnOneColumn) {
  const auto map = parse_import_map(
      replace_once(kMap, "[gyro]", "[[thermometer]]\nname = \"case\"\ncolumn = \"T\"\n[gyro]"), "map.toml");
  ASSERT_FALSE(map);
  EXPECT_NE(text(map.error()).find("map.toml:17:10: "), std::string::npos) << text(map.error());
  EXPECT_NE(text(map.error()).find("is also that of thermometer \"die\""), std::string::npos) << text(map.error());
}

TEST(ImportMap, RefusesAxisOnColumnOfThermometerOrOtherAxis) {
  const auto error_of = [](const std::string& text) {
    const auto map = parse_import_map(text, "map.toml");
    return map ? "" : text_of(map.error());
  };
  EXPECT_NE(error_of(replace_once(kMap, "column = \"w\"", "column = \"T\""))
                .find("map.toml:16:10: \"T\" is also that of thermometer \"die\""),
            std::string::npos);
  const std::string axis = "[[gyro.axis]]\nname = \"x\"\ncolumn = \"w\"\nkind = \"rate\"\nscale = 1\n";
  auto triad = replace_once(kMap, "column = \"w\"\nkind = \"rate\"\nscale = 219.5\n", axis);
  EXPECT_EQ(error_of(triad), "");
  triad = replace_once(triad, "[analysis]", replace_once(axis, "\"x\"", "\"y\"") + "[analysis]");
  EXPECT_NE(error_of(triad).find("\"w\" is also that of another axis"), std::string::npos) << error_of(triad);
}

TEST(ImportMap, ReadsColumnOfCountingTimes) {
  const auto with = [](const std::string& keys) {
    return parse_import_map(
        replace_once(kMap, "kind = \"rate\"\nscale = 219.5\n", "kind = \"increment\"\nscale = 0.1\n" + keys), "m");
  };
  const auto named = with("interval_column = \"gate\"\n"), numbered = with("interval_column_number = 4\n");
  ASSERT_TRUE(named && numbered);
  EXPECT_EQ(named->interval_columns.front()->name, "gate");
  EXPECT_EQ(named->columns().back().name, "gate");
  EXPECT_EQ(named->valid_ranges().size(), named->columns().size());
  EXPECT_EQ(numbered->interval_columns.front()->number, 4u);
  EXPECT_FALSE(with("")->interval_columns.front());
  for (const char* keys :
       {"interval_column = \"w\"\n", "interval_column = \"T\"\n", "interval_column = \"t\"\n", "interval_column = 4\n",
        "interval_column_number = 0\n", "interval_column = \"gate\"\ninterval_column_number = 4\n"}) {
    const auto map = with(keys);
    ASSERT_FALSE(map) << keys;
    EXPECT_EQ(map.error().where.rfind("m:", 0), 0u) << text(map.error());
  }
  const auto rate =
      parse_import_map(replace_once(kMap, "scale = 219.5\n", "scale = 219.5\ninterval_column = \"gate\"\n"), "m");
  ASSERT_FALSE(rate);
  EXPECT_EQ(rate.error().where.rfind("m:19:", 0), 0u) << text(rate.error());
}

TEST(ImportMap, AllowsOneKindOfAxesPerUnit) {
  const auto axis = [](const char* name, const char* kind) {
    return fmt::format("name = \"{0}\"\ncolumn = \"{0}\"\nkind = \"{1}\"\nscale = 1\n", name, kind);
  };
  const auto head = kMap.substr(0, kMap.find("[gyro]"));
  const auto units = head + "[[gyro]]\n" + axis("a", "rate") + "[[gyro]]\n" + axis("b", "increment");
  const auto mixed = parse_import_map(units, "m");
  ASSERT_TRUE(mixed) << text(mixed.error());
  EXPECT_FALSE(mixed->counts_increments(0));
  EXPECT_TRUE(mixed->counts_increments(1));
  const auto map = parse_import_map(
      head + "[gyro]\n[[gyro.axis]]\n" + axis("a", "rate") + "[[gyro.axis]]\n" + axis("b", "increment"), "m");
  ASSERT_FALSE(map);
  EXPECT_NE(text(map.error()).find("m:24:8: a unit's axes are all rates or all increments"), std::string::npos)
      << text(map.error());
}

TEST(ImportMap, ReportsEveryInvalidNameWithPosition) {
  const std::string units = R"([[gyro]]
name = "one two"
[[gyro.axis]]
name = "x"
column = "a"
kind = "rate"
scale = 1
[[gyro.axis]]
name = "X"
column = "b"
kind = "rate"
scale = 1
[[gyro.value]]
name = "a.b"
column = "c"
unit = "V"
[[gyro]]
name = "b"
column = "d"
kind = "rate"
scale = 1
[[gyro]]
name = "B"
column = "e"
kind = "rate"
scale = 1
[[thermometer]]
name = "T*"
column = "f"
[[thermometer]]
name = "DIE"
column = "g"
)";
  const auto map = parse_import_map(kMap.substr(0, kMap.find("[gyro]")) + units, "m");
  ASSERT_FALSE(map);
  EXPECT_EQ(text(map.error()),
            "m:16:8: gyro \"one two\": expected only letters, digits and _ -\n"
            "m:23:8: channel \"one two.X.pulses\": the name is already in use, expected a unique one\n"
            "m:28:8: value \"a.b\": expected only letters, digits and _ -\n"
            "m:37:8: channel \"B.interval_ns\": the name is already in use, expected a unique one\n"
            "m:42:8: thermometer \"T*\": expected only letters, digits, blanks and _ . -\n"
            "m:45:8: thermometer \"DIE\": the name is already in use, expected a unique one");
  const auto missing = parse_import_map(replace_once(kMap, "name = \"die\"\n", ""), "m");
  EXPECT_EQ(text(missing.error()).find("64 characters"), std::string::npos) << text(missing.error());
}

TEST(ImportMap, RequiresAxisOfUnit) {
  const std::string column = "column = \"w\"\nkind = \"rate\"\nscale = 219.5\n";
  const auto map = parse_import_map(replace_once(kMap, column, "axis = []\n"), "m");
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().where.rfind("m:15:", 0), 0u) << text(map.error());
  EXPECT_NE(text(map.error()).find("column"), std::string::npos) << text(map.error());
}

TEST(ImportMap, LimitsWrapToTenYears) {
  const auto map_with = [](const std::string& unit, const std::string& wrap) {
    return parse_import_map(replace_once(kMap, "unit = \"ms\"", "unit = \"" + unit + "\"\nwrap = " + wrap), "m");
  };
  for (const auto& [unit, wrap] : {std::pair("us", "4294967296"),
                                   {"ms", "4294967296"},
                                   {"s", "65536.0"},
                                   {"ns", "1"},
                                   {"ns", "315532800000000000.0"},
                                   {"d", "3652"},
                                   {"h", "0.25"}})
    EXPECT_TRUE(map_with(unit, wrap)) << unit << " " << wrap;
  for (const auto& [unit, wrap] : {std::pair("us", "18446744073709551616.0"),
                                   {"s", "4294967296"},
                                   {"s", "1e300"},
                                   {"d", "3653"},
                                   {"ns", "1e-3"},
                                   {"s", "0"},
                                   {"s", "-1"}}) {
    const auto map = map_with(unit, wrap);
    ASSERT_FALSE(map) << unit << " " << wrap;
    EXPECT_EQ(map.error().where.rfind("m:", 0), 0u) << text(map.error());
    EXPECT_NE(map.error().what.find("wrap"), std::string::npos) << text(map.error());
    EXPECT_NE(map.error().what.find("expected"), std::string::npos) << text(map.error());
  }
}

TEST(ImportMap, AcceptsEveryShippedMap) {
  int maps = 0;
  for (const auto& file : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/imports")) {
    const auto map = load_import_map(file.path());
    EXPECT_TRUE(map) << text(map.error());
    ++maps;
  }
  EXPECT_GE(maps, 4);
}

TEST(ImportMap, DocumentsEveryKey) {
  const auto source = read_text_file(GYROTHERM_SOURCE_DIR "/acquisition/exchange/import_map.cpp").value();
  const auto document = read_text_file(GYROTHERM_SOURCE_DIR "/docs/importing.md").value();
  const std::string getter = "(?:text|number|integer|boolean|texts|tables?|duration|has|choice)\\(",
                    reader = "(?:one_of|read_positive|read_choice)\\([a-zA-Z, ]*", name = "\"([a-z_]+)\"";
  const std::regex key(getter + name + "|" + reader + name);
  std::set<std::string> keys;
  for (std::sregex_iterator match(source.begin(), source.end(), key), end; match != end; ++match)
    keys.insert((*match)[1].matched ? (*match)[1] : (*match)[2]);
  EXPECT_GE(keys.size(), 30u);
  for (const auto& one : keys)
    EXPECT_TRUE(std::regex_search(document, std::regex("`[^`]*\\b" + one + "\\b[^`]*`"))) << one;
}

TEST(ImportMap, ReportsMissingFileAsBadFile) {
  EXPECT_EQ(load_import_map("/nowhere/map.toml").error().kind, FaultKind::bad_file);
}

TEST(ImportMap, RefusesTableKeysForLog) {
  const std::string log = R"(schema = "gyrotherm-import/1"
name = "drone"
[file]
format = "ulog"
[time]
every = "1 s"
[gyro]
column = "sensor_gyro.x"
kind = "rate"
scale = 206264.806247
)";
  const auto map = parse_import_map(log, "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(map->format, FileFormat::ulog);
  EXPECT_EQ(map->every, std::chrono::seconds(1));
  EXPECT_FALSE(map->time);
  EXPECT_FALSE(parse_import_map(replace_once(log, "every", "column = \"t\"\nevery"), "map.toml"));
  EXPECT_FALSE(parse_import_map(replace_once(log, "\"rate\"", "\"increment\""), "map.toml"));
}

TEST(ImportMap, AssignsEachThermometerToUnit) {
  const auto owners = [](const std::string& units) {
    const auto map = parse_import_map(
        "schema = \"gyrotherm-import/1\"\nname = \"m\"\n[file]\n[time]\ninterval = \"1 s\"\n"
        "[[thermometer]]\nname = \"A\"\ncolumn = \"A\"\n[[thermometer]]\nname = \"B\"\ncolumn = \"B\"\n" +
            units,
        "m.toml");
    EXPECT_TRUE(map) << text(map.error());
    std::vector<std::string> found;
    for (const auto& channel : make_channels(*map, "")) found.push_back(channel.unit_under_test);
    return found;
  };
  const auto unit = [](const std::string& name, const std::string& thermometers) {
    return "[[gyro]]\nname = \"" + name + "\"\n" + thermometers + "[[gyro.axis]]\nname = \"x\"\ncolumn = \"" + name +
           "\"\nkind = \"rate\"\nscale = 1\n";
  };
  using Owners = std::vector<std::string>;
  EXPECT_EQ(owners("[gyro]\ncolumn = \"w\"\nkind = \"rate\"\nscale = 1\n"), (Owners{"gyro", "gyro"}));
  EXPECT_EQ(owners(unit("imu", "")), (Owners{"imu", "imu"}));
  EXPECT_EQ(owners(unit("a", "") + unit("b", "")), (Owners{"", ""})) << "they serve both";
  EXPECT_EQ(owners(unit("a", "thermometers = [\"A\"]\n") + unit("b", "thermometers = [\"A\", \"B\"]\n")),
            (Owners{"", "b"}));
}

}  // namespace
}  // namespace gyrotherm::exchange
