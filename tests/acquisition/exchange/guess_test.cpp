// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/guess.hpp"

#include <gtest/gtest.h>

#include "tests/acquisition/exchange/foreign.hpp"

namespace gyrotherm::exchange {
namespace {

/// A guess is a map, and reads the file that it was made of.
ImportMap guessed(std::string_view bytes) {
  const auto text = guess_map_of(bytes, "folder/file.csv");
  EXPECT_TRUE(text) << gyrotherm::text(text.error());
  auto map = parse_import_map(text.value_or(""), "guess.toml");
  EXPECT_TRUE(map) << gyrotherm::text(map.error()) << *text;
  const auto rows = rows_of(bytes, *map, "f");
  EXPECT_TRUE(rows) << gyrotherm::text(rows.error()) << *text;
  return map.value();
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
