// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

class VirtualUsbTempTest : public testing::Test {
 protected:
  std::vector<std::byte> ask(const drivers::MccRequest& request) {
    EXPECT_TRUE(device.write(encode_mcc_request(request)));
    std::vector<std::byte> report(drivers::kMccLongestReport);
    const auto size = device.read(report, {});
    report.resize(size.value_or(0));
    return report;
  }
  VirtualLaboratory laboratory{laboratory_of_rig("virtual"), {}};
  std::mutex guard;
  VirtualUsbTemp device{laboratory, guard, {0, 1, std::nullopt, 3, 4, 5, 6, 8}};
};

TEST_F(VirtualUsbTempTest, ScansItsInputs) {
  const auto scan = drivers::mcc_scan(0, 7);
  const auto readings = drivers::decode_mcc_temperatures(scan, ask(scan));
  ASSERT_TRUE(readings) << text(readings.error());
  const auto laboratory_c = laboratory.thermometers_as_measured_c();
  EXPECT_NEAR((*readings)[1]->value, laboratory_c[1], 2e-6);
  EXPECT_NEAR((*readings)[7]->value, laboratory_c[8], 2e-6);
  EXPECT_EQ((*readings)[2].error().kind, FaultKind::out_of_range);
  const auto one = drivers::mcc_read_input(3);
  EXPECT_NEAR(decode_mcc_temperatures(one, ask(one)).value()[0]->value, laboratory_c[3], 2e-6);
}

TEST_F(VirtualUsbTempTest, StoresItemSettings) {
  const auto sensor = mcc_read_item(5, drivers::MccItem::sensor);
  EXPECT_EQ(decode_mcc_bytes(sensor, ask(sensor)).value(), std::vector<std::uint8_t>{0}) << "the default is platinum";
  for (const auto& request : mcc_setup(5, drivers::MccThermocouple{drivers::MccThermocoupleType::t}))
    EXPECT_TRUE(ask(request).empty());
  EXPECT_EQ(decode_mcc_bytes(sensor, ask(sensor)).value(), std::vector<std::uint8_t>{2});
  EXPECT_TRUE(ask(mcc_set_item(2, drivers::MccItem::coefficient_0, 100.02f)).empty());
  const auto coefficient = mcc_read_item(2, drivers::MccItem::coefficient_0);
  EXPECT_EQ(decode_mcc_numbers(coefficient, ask(coefficient)).value()[0], 100.02f);
}

TEST_F(VirtualUsbTempTest, CalibratesImmediatelyAndReportsDate) {
  EXPECT_TRUE(ask(mcc_request(drivers::MccCommand::calibrate)).empty());
  const auto status = mcc_request(drivers::MccCommand::read_status);
  EXPECT_FALSE(drivers::is_mcc_calibrating(decode_mcc_bytes(status, ask(status)).value()[0]));
  const auto date = drivers::mcc_read_calibration_date();
  EXPECT_TRUE(drivers::decode_mcc_date(drivers::decode_mcc_bytes(date, ask(date)).value()));
}

TEST_F(VirtualUsbTempTest, IgnoresUnknownRequests) {
  EXPECT_TRUE(device.write(std::vector{std::byte{0x99}, std::byte{0}}));
  std::array<std::byte, 64> report{};
  EXPECT_EQ(device.read(report, {}).error().kind, FaultKind::timeout);
}

}  // namespace
}  // namespace gyrotherm::simulator
