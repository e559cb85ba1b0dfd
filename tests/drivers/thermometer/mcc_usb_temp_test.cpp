// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/mcc_usb_temp.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/fake_usb_temp.hpp"
#include "tests/support/hex_bytes.hpp"

namespace gyrotherm::drivers {
namespace {

class OnFakeUsbTemp : public testing::Test {
 protected:
  OnFakeUsbTemp() { connect({.within = std::chrono::milliseconds(20)}); }
  void connect(MccOptions options) {
    auto made = std::make_unique<tests::FakeUsbTemp>();
    device = made.get();
    bank = make_mcc_usb_temp(std::move(made), "bank", std::move(options));
  }
  void expect_all(FaultKind kind) {
    const auto readings = bank->read();
    ASSERT_EQ(readings.size(), kMccInputs);
    for (const auto& reading : readings) EXPECT_EQ(reading.error().kind, kind) << text(reading.error());
  }
  void expect_good() {
    const auto readings = bank->read();
    ASSERT_EQ(readings.size(), kMccInputs);
    for (std::size_t i = 0; i < kMccInputs; ++i)
      EXPECT_EQ(readings[i].value_or(Celsius{-99}), Celsius{device->temperatures[i]}) << i;
  }
  tests::FakeUsbTemp* device{};
  std::unique_ptr<Thermometer> bank;
};
using MccUsbTemp = OnFakeUsbTemp;

MccOptions with_sensors() {
  MccOptions options{.within = std::chrono::milliseconds(20)};
  options.sensors.fill(MccRtd{.r0_ohm = 100.02f});
  return options;
}

TEST_F(MccUsbTemp, ReportsModelSerialNumberAndCalibration) {
  EXPECT_EQ(bank->identify().value(), "MCC USB-TEMP 01234567, calibrated 2024-05-17");
  device->date = {255, 255, 255, 255, 255, 255};
  EXPECT_EQ(bank->identify().value(), "MCC USB-TEMP 01234567");
}

TEST_F(MccUsbTemp, ReadsEightTemperaturesInOneScan) {
  expect_good();
  EXPECT_EQ(device->count(MccCommand::scan), 1);
  EXPECT_EQ(device->count(MccCommand::calibrate), 0) << "nothing was set";
}

TEST_F(MccUsbTemp, ReportsOpenOrImpossibleInput) {
  auto options = with_sensors();
  options.sensors[4] = options.sensors[5] = MccThermocouple{MccThermocoupleType::t};
  connect(options);
  ASSERT_TRUE(bank->identify());
  device->temperatures[0] = 851;  // above the range of RTDs
  device->temperatures[4] = kMccOpen;
  device->temperatures[5] = -271;  // below the range of type T
  device->temperatures[6] = kMccNotReady;
  const auto readings = bank->read();
  for (const auto input : {0, 4, 5, 6}) EXPECT_EQ(readings[input].error().kind, FaultKind::out_of_range) << input;
  EXPECT_EQ(text(readings[4].error()), "bank input 4: open thermocouple (-8888)");
  for (const auto input : {1, 2, 3, 7}) EXPECT_TRUE(readings[input]) << input;
}

TEST_F(MccUsbTemp, SetsDifferingItemsAndCalibratesBeforeReading) {
  connect(with_sensors());
  expect_all(FaultKind::timeout);
  EXPECT_EQ(device->count(MccCommand::calibrate), 1);
  expect_all(FaultKind::timeout);
  expect_good();
  EXPECT_EQ(device->count(MccCommand::calibrate), 1);
  const auto set = device->count(MccCommand::set_item);
  EXPECT_GT(set, 0);
  expect_good();
  EXPECT_EQ(device->count(MccCommand::set_item), set) << "once";
}

TEST_F(MccUsbTemp, WaitsForCalibrationWhenIdentifying) {
  connect(with_sensors());
  EXPECT_TRUE(bank->identify());
  expect_good();
  device->status_reads_of_a_calibration = 1000;
  device->items.clear();
  device->unplug();
  expect_all(FaultKind::disconnected);
  device->plug_in();
  EXPECT_EQ(text(bank->identify().error()), "bank: self-calibration in progress") << "but not for ever";
}

TEST_F(MccUsbTemp, ReportsMismatchIfSettingsAreNotKept) {
  connect(with_sensors());
  device->forget_settings();
  EXPECT_EQ(bank->identify().error().kind, FaultKind::mismatch);
  device->recover();
  EXPECT_TRUE(bank->identify());
}

TEST_F(MccUsbTemp, SensorsThatCannotShareAConverterAreAMismatch) {
  auto options = with_sensors();
  options.sensors[1] = MccThermocouple{MccThermocoupleType::k};
  connect(options);
  EXPECT_EQ(bank->identify().error().kind, FaultKind::mismatch);
}

TEST_F(MccUsbTemp, ComparesSettingsAfterReplug) {
  connect(with_sensors());
  ASSERT_TRUE(bank->identify());
  device->unplug();
  expect_all(FaultKind::disconnected);
  expect_all(FaultKind::disconnected);
  device->plug_in();
  // Another device with the same serial number.
  device->items.clear();
  expect_all(FaultKind::timeout);
  expect_all(FaultKind::timeout);
  expect_good();
  EXPECT_EQ(device->openings, 2);
}

TEST_F(MccUsbTemp, ReportsTimeoutForEveryInput) {
  expect_good();
  device->fall_silent();
  expect_all(FaultKind::timeout);
  device->recover();
  expect_good();
}

TEST_F(MccUsbTemp, DoesNotTakeLateScanForNext) {
  expect_good();
  device->answer_late();
  expect_all(FaultKind::timeout);
  device->recover();
  device->temperatures.fill(30);
  expect_good();
}

TEST_F(MccUsbTemp, DiscardsRepliesToEarlierPrograms) {
  device->leave(tests::parse_hex_bytes("19 00009041 00009041 00009041 00009041 00009041 00009041 00009041 00009041"));
  device->leave(tests::parse_hex_bytes("44 00"));
  expect_good();
}

TEST_F(MccUsbTemp, ListsEveryModelInUdevRule) {
  std::ifstream file(GYROTHERM_SOURCE_DIR "/drivers/60-gyrotherm.rules");
  const std::string rules((std::istreambuf_iterator<char>(file)), {});
  for (const auto& kind : kMccKinds)
    EXPECT_NE(rules.find(fmt::format(R"(KERNELS=="0003:{:04X}:{:04X}.*")", kind.vendor, kind.product)),
              std::string::npos)
        << kind.name;
}

TEST_F(MccUsbTemp, RejectsShortReport) {
  expect_good();
  device->cut_reports();
  expect_all(FaultKind::corrupted);
  device->recover();
  expect_good();
}

}  // namespace
}  // namespace gyrotherm::drivers
