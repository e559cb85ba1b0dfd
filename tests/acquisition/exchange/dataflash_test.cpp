// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/dataflash.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/acquisition/exchange/foreign.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/hex_bytes.hpp"

namespace gyrotherm::exchange {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;

ImportMap dataflash_map(const std::string& rate = "IMU.GyrX", const std::string& temperature = "IMU.T") {
  ImportMap map = rate_map();
  map.format = FileFormat::dataflash;
  map.time.reset();
  map.axis_columns[0].name = rate;
  map.thermometer_columns[0].column.name = temperature;
  return map;
}

DataflashText with_imu() {
  DataflashText log;
  log.format(9, "IMU", "QBfc", "TimeUS,I,GyrX,T", 3 + 15);
  return log;
}
std::string imu(std::uint64_t us, std::uint8_t sensor, float rate, std::int16_t hundredths) {
  return little(us) + little(sensor) + little(rate) + little(hundredths);
}
void number_sensors(DataflashText& log) {
  log.format(10, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", 3 + 41);
  log.message(
      10, little(std::uint64_t{1}) + '\x09' + DataflashText::padded("s#EO", 16) + DataflashText::padded("F---", 16));
}

/// The bytes are written by hand from the description of the format.
TEST(Dataflash, ReadsGoldenLogExactly) {
  auto bytes = tests::parse_hex_bytes(
      "A3 95 80"
      "09 0F"
      "49 4D 55 00");  // FMT of kind 9, 15 bytes, "IMU"
  const auto add = [&](std::string_view text, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(i < text.size() ? text[i] : 0));
  };
  add("IhHe", 16);
  add("TimeMS,GyrX,T,E", 64);
  for (const auto byte : tests::parse_hex_bytes("A3 95 09"
                                                "E8 03 00 00"
                                                "FE FF"
                                                "07 80"
                                                "9C FF FF FF"))
    bytes.push_back(byte);
  const std::string log(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto rows = read_rows(log, dataflash_map("IMU.GyrX", "IMU.E"), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], std::vector<double>{-2});
  EXPECT_EQ(rows->columns[0], std::vector<double>{-1}) << "hundredths";
  EXPECT_EQ(read_rows(log, dataflash_map("IMU.T", "IMU.T"), "f")->columns[1], std::vector<double>{0x8007});
}

TEST(Dataflash, ReadsEveryNumberType) {
  DataflashText log;
  log.format(9, "ALL", "QbBhHiIqfdgcCeELM", "", 0);  // too long for a format, skipped
  log.format(11, "NUM", "QbBhiIqfdgCEL", "TimeUS,b,B,h,i,I,q,f,d,g,C,E,L",
             3 + 8 + 1 + 1 + 2 + 4 + 4 + 8 + 4 + 8 + 2 + 2 + 4 + 4);
  log.message(11, little(std::uint64_t{5}) + little(std::int8_t{-3}) + little(std::uint8_t{200}) +
                      little(std::int16_t{-300}) + little(std::int32_t{-70000}) + little(std::uint32_t{4'000'000'000}) +
                      little(std::int64_t{-5}) + little(0.5F) + little(0.25) + little(std::uint16_t{0xC100}) +
                      little(std::uint16_t{1234}) + little(std::uint32_t{4321}) + little(std::int32_t{450000000}));
  const std::vector<std::pair<std::string, double>> expected{{"b", -3},   {"B", 200},   {"h", -300},  {"i", -70000},
                                                             {"I", 4e9},  {"q", -5},    {"f", 0.5},   {"d", 0.25},
                                                             {"g", -2.5}, {"C", 12.34}, {"E", 43.21}, {"L", 45}};
  for (const auto& [field, number] : expected) {
    const auto rows = read_rows(log.text(), dataflash_map("NUM." + field, "NUM.b"), "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_NEAR(rows->columns[1][0], number, 1e-12) << field;
  }
}

TEST(Dataflash, SeparatesSensorsByNumberField) {
  DataflashText log = with_imu();
  number_sensors(log);
  log.message(9, imu(1000, 0, 1, 3000)).message(9, imu(1100, 1, 2, 4000)).message(9, imu(2000, 0, 3, 3100));
  const auto first = read_rows(log.text(), dataflash_map(), "f");
  ASSERT_TRUE(first) << text(first.error());
  EXPECT_EQ(first->columns[1], (std::vector<double>{1, 3}));
  EXPECT_EQ(first->columns[0], (std::vector<double>{30, 31}));
  EXPECT_EQ(read_rows(log.text(), dataflash_map("IMU[1].GyrX", "IMU[1].T"), "f")->columns[1], std::vector<double>{2});
  DataflashText without = with_imu();
  without.message(9, imu(1000, 0, 1, 3000)).message(9, imu(1100, 1, 2, 4000));
  EXPECT_EQ(read_rows(without.text(), dataflash_map(), "f")->columns[1], (std::vector<double>{1, 2}))
      << "the messages have no number field";
}

TEST(Dataflash, ReportsMessagesBeforeSensorUnits) {
  DataflashText log = with_imu();
  for (unsigned i = 0; i < 3; ++i) log.message(9, imu(500 + i, static_cast<std::uint8_t>(i % 2), 7, 0));
  log.stray("junk");
  number_sensors(log);
  log.message(9, imu(1000, 0, 1, 3000)).message(9, imu(1100, 1, 2, 4000)).message(9, imu(2000, 0, 3, 3100));
  const auto rows = read_rows(log.text(), dataflash_map(), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{1, 3}));
  EXPECT_EQ(rows->notes, (Notes{"4 bytes outside messages were skipped",
                                "3 messages were left out because their sensor was not known yet"}));
  const tests::TestFolder folder;
  std::ofstream(folder / "log.bin", std::ios::binary) << log.text();
  std::vector<double> rates;
  const auto notes =
      read_foreign_file(folder / "log.bin", dataflash_map(), [&](const ImportedRow& row) -> Result<void> {
        rates.push_back(row.numbers[1]);
        return {};
      });
  EXPECT_EQ(notes.value(), rows->notes) << "a file is read twice, like a text in memory";
  EXPECT_EQ(rates, (std::vector<double>{1, 3}));
}

TEST(Dataflash, CombinesSeveralKinds) {
  DataflashText log = with_imu();
  log.format(12, "BARO", "Qf", "TimeUS,Temp", 3 + 12);
  for (unsigned i = 0; i < 2000; ++i) {
    log.message(9, imu(1000 * i, 0, static_cast<float>(i / 1000), 3000));
    if (i % 100 == 0) log.message(12, little(std::uint64_t{1000} * i) + little(25.5F));
  }
  ImportMap map = dataflash_map("IMU.GyrX", "BARO.Temp");
  EXPECT_FALSE(read_rows(log.text(), map, "f"));
  map.every = seconds(1);
  const auto rows = read_rows(log.text(), map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[0], (std::vector<double>{25.5, 25.5}));
  EXPECT_EQ(rows->columns[1], (std::vector<double>{0, 1}));
}

TEST(Dataflash, SkipsAndReportsStrayBytes) {
  DataflashText log = with_imu();
  log.message(9, imu(1000, 0, 1, 3000))
      .stray("\xA3\x95\xFF junk")
      .message(9, imu(2000, 0, 2, 3100))
      .stray("\xA3\x95\x09 cut");
  const auto rows = read_rows(log.text(), dataflash_map(), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{1, 2}));
  EXPECT_EQ(rows->notes, Notes{"15 bytes outside messages were skipped"});
}

TEST(Dataflash, NamesMissingAndExistingColumns) {
  DataflashText log = with_imu();
  log.message(9, imu(1000, 0, 1, 3000));
  EXPECT_EQ(text(read_rows(log.text(), dataflash_map("IMU.GyrY"), "f").error()),
            "f: no column \"IMU.GyrY\", expected one of: \"IMU.TimeUS\", \"IMU.I\", \"IMU.GyrX\", \"IMU.T\"");
  EXPECT_EQ(text(read_rows("t,T\n", dataflash_map(), "f").error()),
            "f: not a DataFlash log, expected one (format = \"dataflash\" in the map)");
}

TEST(Dataflash, ReportsPositionWhenTimeGoesBack) {
  DataflashText log = with_imu();
  log.message(9, imu(2000, 0, 1, 3000)).message(9, imu(1000, 0, 2, 3000));
  const auto rows = read_rows(log.text(), dataflash_map(), "f");
  ASSERT_FALSE(rows);
  EXPECT_EQ(text(rows.error()),
            "f: message at byte 196: the time goes back 0.001 s, expected one after the row before, "
            "or out_of_order = \"skip\" in [time]");
}

}  // namespace
}  // namespace gyrotherm::exchange
