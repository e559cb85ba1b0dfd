// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/own_export.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "acquisition/exchange/export_choice.hpp"
#include "acquisition/exchange/guess.hpp"
#include "acquisition/exchange/import.hpp"
#include "acquisition/exchange/netcdf_export.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/record.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

using record::AxisInfo, record::GyroKind, record::Record, record::UnitInfo, tests::TestFolder;

constexpr int kRecordedRows = 60;

/// Returns a record of one-second rows with the given units; all channels vary.
Record make_varied_record(std::vector<UnitInfo> units, bool imported) {
  Record record;
  record.finished = true;
  record.info.id = "0123456789abcdef0123456789abcdef";
  record.info.program_version = "0.2.0";
  record.info.profile_name = "slow, ramp";
  record.info.rig_name = "bench";
  record.info.imported = imported;
  record.info.units = std::move(units);
  record.info.thermometers = {{"Ofen oben", "", Kelvins{}}, {"shell-1.b", "", Kelvins{-0.25}}};
  if (!imported) record.info.segments = {{"warm up", false, Celsius{70}, CelsiusPerMinute{5}, -1}};
  record.thermometers_c.resize(2);
  for (const UnitInfo& unit : record.info.units) {
    record.units.push_back({.rotation = std::vector<std::vector<double>>(unit.axes.size()),
                            .interval_s = {},
                            .values = std::vector<std::vector<double>>(unit.values.size()),
                            .true_bias_deg_per_h = std::vector<std::vector<double>>(unit.axes.size())});
  }
  for (int row = 0; row < kRecordedRows; ++row) {
    record.slot.push_back(row);
    record.time_s.push_back(row);
    record.set_point_c.push_back(imported ? NAN : 22.5);
    record.chamber_air_c.push_back(imported ? NAN : 20 + 0.1 * row);
    record.chamber_set_point_c.push_back(imported ? NAN : 21);
    record.thermometers_c[0].push_back(20 + 0.125 * row);
    record.thermometers_c[1].push_back(row % 7 == 3 ? NAN : 19 + 0.25 * row);
    record.progress.push_back({.segment = imported ? -1 : 0, .cycle = -1, .set_point = Celsius{22.5}});
    record.state.push_back({});
    for (std::size_t u = 0; u < record.units.size(); ++u) {
      record.units[u].interval_s.push_back(1);
      for (std::size_t axis = 0; axis < record.units[u].rotation.size(); ++axis) {
        record.units[u].rotation[axis].push_back(100 + 31 * (row % 5) + 7 * static_cast<double>(u + 3 * axis));
        record.units[u].true_bias_deg_per_h[axis].push_back(NAN);
      }
      for (auto& value : record.units[u].values) value.push_back(30 + 0.5 * row);
    }
  }
  return record;
}

UnitInfo make_unit_of_axes(const std::string& name, std::vector<AxisInfo> axes) {
  return {.name = name, .axes = std::move(axes)};
}

struct ExportedRecord {
  std::string name;
  Record record;
};

std::vector<ExportedRecord> make_exported_records() {
  const AxisInfo counted{.kind = GyroKind::pulse_count, .scale = 0.1, .earth_rate = DegreesPerHour{10.636}};
  const AxisInfo rate{.kind = GyroKind::rate, .scale = 219.5};
  const auto named = [](AxisInfo axis, const char* name) {
    axis.name = name;
    return axis;
  };
  auto self = make_unit_of_axes("gyro", {counted});
  self.values = {{.name = "die", .unit = "°C", .is_temperature = true}, {.name = "current", .unit = "mA"}};
  std::vector<ExportedRecord> cases{
      {"single", make_varied_record({make_unit_of_axes("gyro", {counted})}, false)},
      {"values", make_varied_record({self}, false)},
      {"lot",
       make_varied_record({make_unit_of_axes("G-1_a", {counted}), make_unit_of_axes("G-2_a", {counted})}, false)},
      {"triad",
       make_varied_record({make_unit_of_axes("imu", {named(rate, "x"), named(rate, "y"), named(rate, "z")})}, false)},
      {"mixed", make_varied_record({make_unit_of_axes("G-1_a", {counted}),
                                    make_unit_of_axes("imu", {named(rate, "x"), named(rate, "y")})},
                                   false)},
      {"imported", make_varied_record({make_unit_of_axes("gyro", {rate})}, true)},
  };
  for (ExportedRecord& one : cases) one.record.info.virtual_rig = one.name == "lot" || one.name == "triad";
  return cases;
}

/// Exports a record, guesses its map and imports the file with this map, without any correction.
Record make_round_trip(const TestFolder& folder, const Record& record, bool as_netcdf, std::string& map,
                       const ExportChoice& choice = {}) {
  const auto file = folder / (as_netcdf ? "table.nc" : "table.csv");
  if (as_netcdf)
    EXPECT_TRUE(export_netcdf(record, choice, file));
  else
    std::ofstream(file) << record::to_csv(record);
  const auto guessed = guess_map(file);
  EXPECT_TRUE(guessed) << text(guessed.error());
  map = guessed.value_or("");
  std::ofstream(folder / "map.toml") << map;
  const auto imported = import_record(file, folder / "map.toml", folder / "back.db", "0.2.0");
  EXPECT_TRUE(imported) << text(imported.error()) << map;
  return imported ? record::read_record(folder / "back.db").value() : Record{};
}

void expect_same_numbers(const std::vector<double>& back, const std::vector<double>& original, std::size_t first) {
  ASSERT_EQ(back.size(), original.size());
  for (std::size_t row = first; row < back.size(); ++row) {
    EXPECT_EQ(std::isnan(back[row]), std::isnan(original[row])) << row;
    if (!std::isnan(original[row])) EXPECT_NEAR(back[row], original[row], 1e-9 * std::abs(original[row])) << row;
  }
}

TEST(OwnExport, ComesBackFromTableAndNetcdfOfEveryKindOfRecord) {
  for (const ExportedRecord& one : make_exported_records())
    for (const bool as_netcdf : {false, true}) {
      SCOPED_TRACE(one.name + (as_netcdf ? " NetCDF" : " CSV"));
      const TestFolder folder;
      std::string map;
      const Record back = make_round_trip(folder, one.record, as_netcdf, map);
      SCOPED_TRACE(map);
      EXPECT_EQ(back.time_s, one.record.time_s);
      EXPECT_EQ(is_simulated(back.info), is_simulated(one.record.info));
      ASSERT_EQ(back.info.thermometers.size(), 2u);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(back.info.thermometers[i].name, one.record.info.thermometers[i].name);
        expect_same_numbers(exchange::calibrated_temperatures(back, i),
                            exchange::calibrated_temperatures(one.record, i), 0);
      }
      ASSERT_EQ(back.units.size(), one.record.units.size());
      for (std::size_t unit = 0; unit < back.units.size(); ++unit) {
        const auto &was = one.record.info.units[unit], &is = back.info.units[unit];
        EXPECT_EQ(is.name, was.name);
        EXPECT_EQ(is.values.size(), was.values.size());  // NetCDF sorts its variables
        for (const auto& value : was.values) EXPECT_EQ(std::ranges::count(is.values, value), 1) << value.name;
        ASSERT_EQ(is.axes.size(), was.axes.size());
        for (std::size_t axis = 0; axis < is.axes.size(); ++axis) {
          EXPECT_EQ(is.axes[axis].name, was.axes[axis].name);
          EXPECT_EQ(is.axes[axis].earth_rate, was.axes[axis].earth_rate);
          expect_same_numbers(axis_rates(back, unit, axis), axis_rates(one.record, unit, axis), 0);
        }
      }
    }
}

/// Returns the bias-giving rates of a record by their times, without missing ones.
std::map<double, double> known_rates(const Record& record, std::size_t unit, std::size_t axis) {
  std::map<double, double> rates;
  const auto all = axis_rates(record, unit, axis);
  for (std::size_t row = 0; row < all.size(); ++row)
    if (!std::isnan(all[row])) rates[record.time_s[row]] = all[row];
  return rates;
}

/// Returns a record of pulses whose counting times differ from the spacing of the rows: a gap of 30 s, an incomplete
/// interval at the end, rows without a reading, and two units with counting times of their own.
Record make_counted_record(bool has_one_unit) {
  const AxisInfo counted{.name = "x", .kind = GyroKind::pulse_count, .scale = 0.1, .earth_rate = DegreesPerHour{9.5}};
  auto other = counted;
  other.name = "y";
  std::vector<UnitInfo> units{make_unit_of_axes("gyro", {counted})};
  if (!has_one_unit) units = {make_unit_of_axes("G-1_a", {counted}), make_unit_of_axes("imu", {counted, other})};
  Record record = make_varied_record(units, false);
  for (std::size_t row = 0; row < record.slot.size(); ++row) {
    if (row >= 20) record.slot[row] += 30;
    record.time_s[row] = static_cast<double>(record.slot[row]);
    for (std::size_t unit = 0; unit < record.units.size(); ++unit)
      record.units[unit].interval_s[row] = 1.000005 + 1e-6 * static_cast<double>(row % 7 + unit);
  }
  record.units.back().interval_s.back() = 0.400002;
  for (auto& axis : record.units.front().rotation) axis[30] = NAN;
  record.units.front().interval_s[30] = NAN;
  return record;
}

TEST(OwnExport, ComesBackWithItsCountingTimes) {
  for (const bool has_one_unit : {true, false})
    for (const bool as_netcdf : {false, true})
      for (const Duration every : {Duration{}, Duration(std::chrono::seconds(7))}) {
        SCOPED_TRACE(fmt::format("{} {} {}", has_one_unit, as_netcdf, every.count()));
        const TestFolder folder;
        const ExportChoice choice{.every = every};
        const Record original = chosen_rows(make_counted_record(has_one_unit), choice);
        std::string map;
        const Record back = make_round_trip(folder, original, as_netcdf, map, choice);
        SCOPED_TRACE(map);
        ASSERT_EQ(back.units.size(), original.units.size());
        for (std::size_t unit = 0; unit < back.units.size(); ++unit) {
          ASSERT_EQ(back.units[unit].rotation.size(), original.units[unit].rotation.size());
          for (std::size_t axis = 0; axis < back.units[unit].rotation.size(); ++axis) {
            EXPECT_EQ(back.info.units[unit].axes[axis].kind, GyroKind::pulse_count);
            EXPECT_EQ(back.info.units[unit].axes[axis].earth_rate, DegreesPerHour{9.5});
            const auto is = known_rates(back, unit, axis), was = known_rates(original, unit, axis);
            EXPECT_EQ(is.size(), was.size());
            for (const auto& [time_s, rate] : was) {
              ASSERT_TRUE(is.contains(time_s)) << time_s;
              // The times have a resolution of 1 ns.
              EXPECT_NEAR(is.at(time_s), rate, 1e-8 * rate) << time_s;
            }
          }
        }
      }
}

TEST(OwnExport, ComesBackWithThermometersOfEachUnit) {
  for (const bool has_one_unit : {true, false})
    for (const bool as_netcdf : {false, true}) {
      SCOPED_TRACE(fmt::format("{} {}", has_one_unit, as_netcdf));
      Record record = make_counted_record(has_one_unit);
      record.info.thermometers.push_back({"T 3", "", Kelvins{}});
      record.thermometers_c.push_back(record.thermometers_c.front());
      auto& units = record.info.units;
      units.front().gradients = {"shell-1.b", "Ofen oben"};
      units.back().three_point = {"Ofen oben", "shell-1.b", "T 3"};
      const TestFolder folder;
      std::string map;
      const Record back = make_round_trip(folder, record, as_netcdf, map);
      SCOPED_TRACE(map);
      ASSERT_EQ(back.info.units.size(), units.size());
      for (std::size_t unit = 0; unit < units.size(); ++unit) {
        EXPECT_EQ(back.info.units[unit].gradients, units[unit].gradients);
        EXPECT_EQ(back.info.units[unit].three_point, units[unit].three_point);
      }
      if (has_one_unit) continue;
      for (const auto& thermometer : back.info.thermometers)
        EXPECT_EQ(thermometer.unit_under_test, thermometer.name == "T 3" ? "imu" : "") << thermometer.name;
    }
}

/// A list that names a thermometer without a column would make the map invalid.
TEST(OwnExport, LeavesOutListsThatTableDoesNotSupport) {
  const std::vector<std::string> titles{
      "slot",   "time [s]", "set point [°C]", "chamber air [°C]", "chamber set point [°C]",
      "A [°C]", "B [°C]",   "u1 [0.5 °/h]"};
  const auto with = [&](const std::vector<std::string>& comments) {
    return find_own_columns(titles, comments).value();
  };
  const auto both = with({"unit u1: gradients B, A", "unit u2: three point A, B, A"});
  EXPECT_EQ(both.axes.at(0).gradients, (std::vector<std::string>{"B", "A"}));
  EXPECT_TRUE(both.axes.at(0).three_point.empty());
  EXPECT_NE(own_sections(both).find("thermometers = [\"B\", \"A\"]\n"), std::string::npos) << own_sections(both);
  for (const char* comment : {"unit u1: gradients A, C", "unit u1: gradients ", "unit u1: gradients A,", "unit u1: "})
    EXPECT_TRUE(with({comment}).axes.at(0).gradients.empty()) << comment;
}

/// Tables that earlier builds or other programs shortened may lack the counting times.
TEST(OwnExport, UsesSpacingOfRowsWithoutCountingTimes) {
  const std::vector<std::string> titles{"slot",
                                        "time [s]",
                                        "set point [°C]",
                                        "chamber air [°C]",
                                        "chamber set point [°C]",
                                        "u1 [pulses of 0.5 arcsec]",
                                        "u2 interval [s]"};
  const auto own = find_own_columns(titles, {});
  ASSERT_TRUE(own);
  EXPECT_EQ(own->axes.at(0).interval, "");
  EXPECT_EQ(own_sections(*own).find("interval_column"), std::string::npos);
  const NetcdfVariable rate{.name = "r", .long_name = "rate about u1, including the Earth rate", .earth_rate = "3"};
  const NetcdfVariable pulses{.name = "n", .long_name = "pulses of u1", .arcsec_per_pulse = "0.5"};
  const NetcdfVariable time{.name = "i", .long_name = "time over which pulses of u1 were counted"};
  EXPECT_EQ(find_own_columns(std::vector{rate, pulses})->axes.at(0).kind, GyroKind::rate);
  EXPECT_EQ(find_own_columns(std::vector{rate, time})->axes.at(0).column, "r");
  const auto counted = find_own_columns(std::vector{time, pulses, rate});
  ASSERT_TRUE(counted);
  EXPECT_EQ(counted->axes.at(0).column, "n");
  EXPECT_EQ(counted->axes.at(0).scale, "0.5");
  EXPECT_EQ(counted->axes.at(0).interval, "i");
  EXPECT_EQ(counted->axes.at(0).earth_rate, "3");
}

TEST(OwnExport, StatesCorrectionThatMapCannotHold) {
  Record record = make_varied_record({make_unit_of_axes("gyro", {{.kind = GyroKind::rate, .scale = 1}})}, true);
  record.info.thermometers[0].polynomial = {0.5, 1.01};
  record.info.thermometers[1].polynomial = {0.1, 1, 1e-4};
  const auto map = guess_map_from_bytes(record::to_csv(record), "table.csv");
  ASSERT_TRUE(map);
  EXPECT_NE(map->find("scale = 1.01\noffset = 0.5 "), std::string::npos) << *map;
  const auto at = map->find("# The table has the reading.");
  ASSERT_NE(at, std::string::npos) << *map;
  EXPECT_GT(at, map->find("name = \"shell-1.b\""));
}

TEST(OwnExport, ReadsBiasOfCompensatedTableOnly) {
  const auto own = find_own_columns(
      {"time [s]", "A [°C]", "self", "bias [°/h]", "compensated [°/h]", "U of a mean over 100 s [°/h]"}, {});
  ASSERT_TRUE(own);
  ASSERT_EQ(own->axes.size(), 1u);
  EXPECT_EQ(own->axes[0].column, "bias [°/h]");
  ASSERT_EQ(own->thermometers.size(), 1u);
  EXPECT_EQ(own->thermometers[0].name, "A");
  EXPECT_FALSE(find_own_columns({"time [s]", "A [°C]", "bias [°/h]"}, {}));
}

TEST(OwnExport, LeavesTablesOfOtherProgramsAlone) {
  EXPECT_FALSE(find_own_columns({"slot", "time [s]", "A [°C]", "gyro [1 °/h]"}, {}));
  EXPECT_FALSE(find_own_columns(std::vector<std::string>{}, {}));
  EXPECT_FALSE(find_own_columns(std::vector<NetcdfVariable>{{.name = "time", .units = "s"}}));
  const auto own = find_own_columns({"slot", "time [s]", "set point [°C]", "chamber air [°C]", "chamber set point [°C]",
                                     "chamber humidity [%]", "chamber dew point [°C]", "A [°C]", "u1 [0.5 °/h]",
                                     "u1 interval [s]", "segment", "cycle", "phase", "turned", "true bias [°/h]"},
                                    {"axis u1: scale 0.5, earth rate 3.5"});
  ASSERT_TRUE(own);
  EXPECT_EQ(own->thermometers.size(), 1u);
  ASSERT_EQ(own->axes.size(), 1u);
  EXPECT_EQ(own->axes[0].earth_rate, "3.5");
  EXPECT_TRUE(own->has_turned && own->values.empty());
}

/// A table with columns that are empty in every row has a header that is wider than its rows.
TEST(TableSample, FindsHeaderAboveColumnsThatAreAlwaysEmpty) {
  for (int empty = 0; empty <= 6; ++empty) {
    std::string table = "Time [s];Oven [°C];Gyro x [°/h]", commas(static_cast<std::size_t>(empty), ';');
    for (int i = 0; i < empty; ++i) table += fmt::format(";note {}", i);
    for (int row = 0; row < 20; ++row) table += fmt::format("\n{};20.5;0.{}{}", row, row % 9, commas);
    const auto map = guess_map_from_bytes(table + "\n", "table.csv");
    ASSERT_TRUE(map);
    EXPECT_NE(map->find("column = \"Gyro x [°/h]\""), std::string::npos) << empty << *map;
  }
}

}  // namespace
}  // namespace gyrotherm::exchange
