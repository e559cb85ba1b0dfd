// SPDX-License-Identifier: Apache-2.0
/// Modbus TCP between a driver and the virtual instruments of its process.
#include "sequencer/rig/wires.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "sequencer/rig/rig.hpp"

namespace gyrotherm::rig {
namespace {

std::ptrdiff_t count_descriptors() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
}

class WiresToVirtualRig : public testing::Test {
 protected:
  /// Connects to the chamber as to a unit with this number and reads its air temperature.
  [[nodiscard]] Result<std::vector<std::uint16_t>> read_air_as(std::uint8_t number) {
    drivers::RegisterMap map = file.chamber_map;
    map.link.modbus.unit = number;
    return wires->chamber(map)->read(drivers::ReadFunction::holding_registers, air.address, word_count(air.type));
  }

  RigFile file = read_rig("virtual").value();
  std::unique_ptr<Wires> wires = make_attended_wires(serve_virtual(file, {}, {.attended = true}).value(), {}, {});
  const drivers::RegisterItem& air = *file.chamber_map.find("air_temperature");
  const std::uint8_t unit = file.chamber_map.link.modbus.unit;
};

TEST_F(WiresToVirtualRig, ReadModbusTcpWithoutDescriptor) {
  ASSERT_EQ(file.chamber_map.link.kind, drivers::LinkKind::tcp);
  const auto before = count_descriptors();
  const auto chamber = wires->chamber(file.chamber_map);
  const auto first = chamber->read(drivers::ReadFunction::holding_registers, air.address, word_count(air.type));
  ASSERT_TRUE(first) << text(first.error());
  EXPECT_EQ(first->size(), word_count(air.type));
  for (int second = 0; second < 100; ++second) {
    wires->let_pass(1);
    ASSERT_TRUE(chamber->read(drivers::ReadFunction::holding_registers, air.address, word_count(air.type)));
  }
  EXPECT_EQ(count_descriptors(), before);
  EXPECT_EQ(chamber->breaks(), 0u);
}

TEST_F(WiresToVirtualRig, ReportTimeoutOfOtherUnitAndStillServeTheirOwn) {
  const auto silent = read_air_as(static_cast<std::uint8_t>(unit + 1));
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().kind, FaultKind::timeout);
  EXPECT_TRUE(read_air_as(unit));
}

TEST_F(WiresToVirtualRig, KeepConnectionAfterRefusedRequest) {
  const auto chamber = wires->chamber(file.chamber_map);
  const auto refused = chamber->read(drivers::ReadFunction::holding_registers, 0xFFF0, 8);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::refused);
  EXPECT_TRUE(chamber->read(drivers::ReadFunction::holding_registers, air.address, word_count(air.type)));
  EXPECT_EQ(chamber->breaks(), 0u);
}

/// Two drivers of one unit have separate connections, so neither receives the answers of the other.
TEST_F(WiresToVirtualRig, AnswerEachConnectionSeparately) {
  const auto one = wires->chamber(file.chamber_map), two = wires->chamber(file.chamber_map);
  for (int i = 0; i < 10; ++i) {
    const auto a = one->read(drivers::ReadFunction::holding_registers, air.address, 1);
    const auto b = two->read(drivers::ReadFunction::holding_registers, air.address, word_count(air.type));
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->size(), 1u);
    EXPECT_EQ(b->size(), word_count(air.type));
    EXPECT_EQ(a->front(), b->front());
  }
}

}  // namespace
}  // namespace gyrotherm::rig
