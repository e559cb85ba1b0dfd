// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/servers/asking.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

class Pt12SessionTest : public testing::Test {
 protected:
  [[nodiscard]] double reading_c(std::size_t place) const { return laboratory.thermometers_as_measured_c()[place]; }

  VirtualLaboratory laboratory{laboratory_of_rig("virtual"), {}};
  Pt12Session session{laboratory, {0, std::nullopt, 8}};
};

TEST_F(Pt12SessionTest, ReportsIdentityInAnyCase) {
  EXPECT_EQ(ask(session, "ID?\r"), "PT12\r\n");
  EXPECT_EQ(ask(session, "id?\r\nsn?\r\n"), "PT12\r\nVIRTUAL1\r\n");
}

TEST_F(Pt12SessionTest, ReadsTwelveInputsOrOne) {
  const auto reply = ask(session, "T?\r\n");
  ASSERT_TRUE(reply.ends_with("\r\n"));
  const auto readings = drivers::decode_pt12_temperatures(reply.substr(0, reply.size() - 2));
  ASSERT_TRUE(readings) << text(readings.error());
  EXPECT_NEAR((*readings)[0]->value, reading_c(0), 5e-6);
  EXPECT_EQ((*readings)[1].error().kind, FaultKind::out_of_range);
  EXPECT_NEAR((*readings)[2]->value, reading_c(8), 5e-6);
  EXPECT_NEAR(std::stod(ask(session, "T3?\r")), reading_c(8), 5e-6);
  EXPECT_EQ(ask(session, "T12?\r"), "NaN\r\n");
  EXPECT_EQ(ask(session, "CONNECTED?\r"), "1, 3\r\n");
}

TEST_F(Pt12SessionTest, IgnoresUnknownCommands) {
  for (const char* command : {"\r", "T13?\r", "T0?\r", "Tx?\r", "T-1?\r", "T?x\r", "R?\r"})
    EXPECT_EQ(ask(session, command), "") << command;
  EXPECT_EQ(ask(session, std::string(100000, 'T') + "\r"), "");
}

}  // namespace
}  // namespace gyrotherm::simulator
