// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/guess.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "tests/acquisition/exchange/foreign.hpp"

namespace gyrotherm::exchange {
namespace {

/// A guess is a map, and reads the file that it was made of.
struct Guessed {
  std::string text;
  ImportMap map;
  ReadRows rows;
};

Guessed guessed_of(std::string_view bytes) {
  const auto text = guess_map_of(bytes, "folder/file.csv");
  EXPECT_TRUE(text) << gyrotherm::text(text.error());
  auto map = parse_import_map(text.value_or(""), "guess.toml");
  EXPECT_TRUE(map) << gyrotherm::text(map.error()) << *text;
  const auto rows = rows_of(bytes, *map, "f");
  EXPECT_TRUE(rows) << gyrotherm::text(rows.error()) << *text;
  return {text.value(), map.value(), rows.value()};
}

ImportMap guessed(std::string_view bytes) { return guessed_of(bytes).map; }

/// The line of a map that gives a key, with what stands behind it.
std::string line_of(const std::string& map, const std::string& key, const std::string& behind = "[time]") {
  const auto at = map.find("\n" + key + " = ", map.find(behind));
  return at == std::string::npos ? "" : map.substr(at + 1, map.find('\n', at + 1) - at - 1);
}

/// A table of rows 4000 apart.
std::string counter(const std::string& name, std::int64_t from, std::int64_t step = 4000) {
  std::string table = name + ",temp,gyro_x\n";
  for (int i = 0; i < 20; ++i) table += std::to_string(from + step * i) + ",25,0.01\n";
  return table;
}

TEST(Guess, ATableOfASpreadsheetIsReadAtOnce) {
  const ImportMap map = guessed(
      "\xEF\xBB\xBFsep=;\r\nZeit [ms];Gehäuse Temp [°C];Kern T [°C];Gyro X [°/s];Gyro Y [°/s]\r\n"
      "0;20,5;21,5;0,001;0,002\r\n1000;20,6;;0,001;NaN\r\n2000;20,7;21,7;0,001;0,002\r\n");
  EXPECT_EQ(map.separator, ';');
  EXPECT_EQ(map.decimal, ',');
  EXPECT_EQ(map.missing, (std::vector<std::string>{"", "NaN"}));
  EXPECT_EQ(map.time->name, "Zeit [ms]");
  EXPECT_EQ(map.time_unit, std::chrono::milliseconds(1));
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"Geh use Temp", "Kern T"}));
  ASSERT_EQ(map.units[0].axes.size(), 2u);
  EXPECT_EQ(map.units[0].axes[1].name, "y");
  EXPECT_EQ(map.units[0].axes[1].scale, 3600);
  EXPECT_EQ(map.every, Duration{}) << "a row a second stays one";
}

TEST(Guess, AThermometerHasNoNameThatEveryRecordHas) {
  const ImportMap map = guessed(
      "slot,time [s],set point [°C],chamber air [°C],A [°C],self temp [°C],gyro [°/h]\n"
      "0,1,20,20.5,21,22,0.1\n1,2,20,20.5,21,22,0.1\n2,3,20,20.5,21,22,0.1\n");
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"set pointT", "chamber airT", "A", "self temp"}));
}

TEST(Guess, FastRowsArePutTogether) {
  std::string table = "timestamp,temp,gx,gy,gz\n";
  for (int i = 0; i < 100; ++i) table += std::to_string(i * 10) + ",20,1,2,3\n";
  const ImportMap map = guessed(table);
  EXPECT_EQ(map.time_unit, std::chrono::milliseconds(1)) << "rows do not come every 10 s";
  EXPECT_EQ(map.units[0].axes.size(), 3u);
}

TEST(Guess, TimesSince1970AndOfTheCalendarAreKnown) {
  EXPECT_EQ(guessed("time,T,w\n1772362800000,20,1\n1772362801000,20,1\n").since, Duration{});
  const ImportMap map = guessed("when\tT\tw\n2026-03-01 12:00:00\t20\t1\n2026-03-01 12:00:01\t20\t1\n");
  EXPECT_EQ(map.time_form, TimeForm::civil);
  EXPECT_EQ(map.zone, Duration{});
  EXPECT_EQ(map.separator, '\t');
}

TEST(Guess, ACounterOfMicrosecondsIsNoClock) {
  for (const char* name : {"time_us", "TimeUS", "t [us]", "t (µs)", "Time [ US ]", "us"}) {
    const Guessed guess = guessed_of(counter(name, 1'200'000'000));
    EXPECT_EQ(guess.map.time_unit, std::chrono::microseconds(1)) << name;
    EXPECT_EQ(guess.map.since, std::nullopt) << name;
    EXPECT_EQ(guess.rows.time.size(), 1u) << "all in one second: " << name;
    EXPECT_EQ(line_of(guess.text, "unit"), "unit = \"us\"        # as its name says");
  }
  const Guessed bare = guessed_of(counter("timestamp", 1'200'000'000));
  EXPECT_EQ(bare.map.since, std::nullopt) << "rows would come every hour";
  EXPECT_EQ(line_of(bare.text, "unit"), "unit = \"ms\"        # a guess by its steps");
}

TEST(Guess, AClockAgreesWithTheUnitInItsName) {
  const Guessed named = guessed_of(counter("time_us", 1'772'362'800'000'000));
  EXPECT_EQ(named.map.since, Duration{});
  EXPECT_NE(line_of(named.text, "since").find("# by the size of its numbers"), std::string::npos) << named.text;
  const Guessed bare = guessed_of(counter("time", 1'772'362'800'000));
  EXPECT_EQ(bare.map.time_unit, std::chrono::milliseconds(1));
  EXPECT_EQ(line_of(bare.text, "unit"), "unit = \"ms\"        # a guess by the size of its numbers");
  EXPECT_EQ(guessed(counter("time [s]", 1'772'362'800, 1)).since, Duration{});
  EXPECT_EQ(guessed(counter("time [UTC]", 1'772'362'800, 300)).since, Duration{}) << "a row every five minutes";
  EXPECT_EQ(guessed(counter("time [ms]", 1'772'362'800, 1)).since, std::nullopt);
}

TEST(Guess, AUnitThatAMapHasNotIsSaidBesideTheGuess) {
  EXPECT_EQ(line_of(guessed_of("t [min],T,w\n0,20,1\n0.5,20,1\n1,20,1\n").text, "unit"),
            "unit = \"s\"        # a guess by its steps, a map knows no \"min\"");
}

TEST(Guess, AUnitOfARateCountsAsAWholeOrIsAGuess) {
  const auto scale_of = [](const std::string& name) {
    const Guessed guess = guessed_of("t [s],T [°C]," + name + "\n0,20,1\n1,20,1\n");
    const bool is_said = line_of(guess.text, "scale").find("a guess") != std::string::npos;
    return std::pair(guess.map.units[0].axes[0].scale, is_said);
  };
  for (const char* name : {"gyro_x [mdps]", "gyro_x [mdeg/s]", "gyro_x [kdeg/s]", "gyro_x [0.01 deg/s]",
                           "gyro_x (mrad/s)", "gyro_x [µrad/s]", "gyro_x_mdps", "gyro_x_100_dps", "gyro_x [deg/s/s]",
                           "gyro_x_mrad", "gyro_x [deg/s] [raw]", "gyro_x"})
    EXPECT_EQ(scale_of(name), std::pair(1., true)) << name;
  for (const char* name : {"gyro_x [dps]", "gyro_x [deg/s]", "gyro_x (°/s)", "gyro_x_dps", "gyro_x_deg_per_s",
                           "gyro_x dps", "gyro_x [ deg / s ]", "gyro_1x_dps"})
    EXPECT_EQ(scale_of(name), std::pair(3600., false)) << name;
  for (const char* name : {"gyro_x [rad/s]", "gyro_x_radps", "sensor_combined.gyro_rad[0]"})
    EXPECT_NEAR(scale_of(name).first, 206264.806247, 1e-6) << name;
  EXPECT_EQ(scale_of("gyro_x [°/h]"), std::pair(1., false));
}

TEST(Guess, AThermometerThatIsNotInCelsiusIsCorrectedOrSaid) {
  const auto lines_of = [](const std::string& name) {
    const auto text = guessed_of("t [s]," + name + ",gyro_x\n0,20,1\n1,20,1\n").text;
    const auto from = text.find("[[thermometer]]"), column = text.find("column", from);
    return text.substr(column, text.find("\n\n", column) - column);
  };
  for (const char* name : {"Temp [°C]", "T1 (degC)", "die T [C]", "temp_c", "temp_degC"})
    EXPECT_EQ(lines_of(name), "column = \"" + std::string(name) + "\"");
  EXPECT_EQ(lines_of("Temp [K]"), "column = \"Temp [K]\"\noffset = -273.15        # of kelvins");
  for (const char* unit : {"°F", "mK", "m°C", "0.01 °C"})
    EXPECT_EQ(lines_of("Temp [" + std::string(unit) + "]"), "column = \"Temp [" + std::string(unit) +
                                                                "]\"        # a guess, \"" + unit +
                                                                "\" is not known: °C = number × scale + offset");
  for (const char* name : {"temp", "temp_raw", "temp_mC", "T1"})
    EXPECT_EQ(lines_of(name),
              "column = \"" + std::string(name) + "\"        # a guess that it is in °C: °C = number × scale + offset");
}

TEST(Guess, ADateApartFromTheTimeOfDayIsNoTime) {
  const Guessed guess = guessed_of(
      "Index,Date,Time,T1,gyro_x\n5,2026-03-01,12:00:00,20,1\n6,2026-03-01,12:00:01,20,1\n"
      "7,2026-03-01,12:00:02,20,1\n8,2026-03-01,12:00:03,20,1\n");
  EXPECT_EQ(guess.map.time->name, "Index");
  EXPECT_EQ(guess.rows.time.size(), 4u) << "no row is left out";
  const auto none = guess_map_of("Date,T1,gyro_x\n2026-03-01,20,1\n2026-03-01,20,1\n2026-03-01,20,1\n", "f").value();
  EXPECT_EQ(line_of(none, "column", "[time]").rfind("column = \"T1\"", 0), 0u) << none;
  EXPECT_EQ(none.find("out_of_order"), std::string::npos) << none;
  EXPECT_EQ(guessed("time,T,w\n5,20,1\n5,20,1\n5,20,1\n6,20,1\n").interval, std::chrono::seconds(1))
      << "most rows are not after the one before";
  EXPECT_EQ(guessed("when,T,w\n2026-03-01,20,1\n2026-03-02,20,1\n").time_form, TimeForm::civil) << "a row a day";
}

TEST(Guess, AHeaderInLatin1IsFoundAgain) {
  const Guessed guess = guessed_of(
      "Zeit [s];T [\xB0"
      "C];Gyro X [\xB0/s]\n0;20;1\n1;\xFC;1\n2;20;1\n");
  EXPECT_EQ(guess.map.thermometer_columns[0].column.name, "T [°C]");
  EXPECT_EQ(guess.map.missing, std::vector<std::string>{"ü"});
  EXPECT_EQ(guess.map.units[0].axes[0].scale, 3600);
}

TEST(Guess, ANameMayHaveQuotes) {
  EXPECT_EQ(guessed("t [s],\"T \"\"die\"\"\",w\n0,20,1\n1,20,1\n").time->name, "t [s]");
}

TEST(Guess, ARowOfUnitsUnderTheHeaderIsNoRow) {
  const Guessed guess = guessed_of("Time,Temp,Rate\ns,degC,deg/h\n0,20,1\n1,20,1\n2,20,2\n");
  EXPECT_EQ(guess.map.skip, 1u);
  EXPECT_EQ(guess.map.missing, std::vector<std::string>{});
  EXPECT_EQ(guess.rows.time.size(), 3u);
  const Guessed apart = guessed_of("# a\nTime,Temp,Rate\n# b\n\ns,degC,deg/h\n0,20,1\n1,20,1\n");
  EXPECT_EQ(apart.map.skip, 2u) << "an empty line counts, a comment does not";
  EXPECT_EQ(apart.rows.time.size(), 2u);
  EXPECT_EQ(guessed("Time,Temp,Rate\n0,x,y\n1,20,1\n2,20,2\n").skip, 0u) << "a row with a number is one";
}

TEST(Guess, WithoutAHeaderColumnsAreNumbers) {
  const ImportMap map = guessed("% made by hand\n0 20 5\n1 21 6\n2 22 7\n");
  EXPECT_FALSE(map.header);
  EXPECT_EQ(map.comment, "%");
  EXPECT_EQ(map.time->number, 1u);
  EXPECT_EQ(map.axis_columns[0].number, 3u);
}

TEST(Guess, TimeThatGoesBackIsSeen) {
  EXPECT_TRUE(guessed("time,T,w\n0,20,1\n2,20,1\n1,20,1\n3,20,1\n").skips_out_of_order);
}

TEST(Guess, LogsAreKnownByTheirFirstBytes) {
  UlogText px4;
  px4.format("sensor_gyro:uint64_t timestamp;float x;float y;float z;float temperature;");
  px4.format("sensor_baro:uint64_t timestamp;float temperature;")
      .subscribe(0, "sensor_baro")
      .subscribe(1, "sensor_gyro");
  px4.data(1, little(std::uint64_t{1000}) + little(1.F) + little(2.F) + little(3.F) + little(30.F));
  const ImportMap map = guessed(px4.text());
  EXPECT_EQ(map.format, FileFormat::ulog);
  EXPECT_EQ(map.thermometers, (std::vector<std::string>{"sensor_baro.temperature", "sensor_gyro.temperature"}));
  ASSERT_EQ(map.axis_columns.size(), 3u);
  EXPECT_EQ(map.axis_columns[2].name, "sensor_gyro.z");
  EXPECT_NEAR(map.units[0].axes[0].scale, 206264.806247, 1e-6);
  DataflashText ardupilot;
  ardupilot.format(9, "IMU", "Qfff", "TimeUS,GyrX,GyrY,T", 23);
  ardupilot.message(9, little(std::uint64_t{1000}) + little(1.F) + little(2.F) + little(30.F));
  EXPECT_EQ(guessed(ardupilot.text()).axis_columns.size(), 2u);
}

TEST(Guess, WhatIsNoTableIsRefused) {
  for (const std::string bytes : {"", "\n\n", "one\ntwo\n", "#\n", "a,b\n"}) {
    const auto map = guess_map_of(bytes, "f");
    ASSERT_FALSE(map) << bytes;
    EXPECT_EQ(text(map.error()), "f: no text table of two columns or more, and no log that is known");
  }
}

TEST(Guess, ATableWithoutAGyroIsAskedForIt) {
  const auto map = guess_map_of("time,T\n0,20\n1,21\n", "f");
  ASSERT_TRUE(map);
  EXPECT_NE(map->find("column = \"\"        # which column is the gyro's?"), std::string::npos) << *map;
}

}  // namespace
}  // namespace gyrotherm::exchange
