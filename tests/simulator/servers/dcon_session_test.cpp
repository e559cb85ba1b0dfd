// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/servers/asking.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

class DconSessionTest : public testing::Test {
 protected:
  [[nodiscard]] double reading_c(std::size_t place) const { return laboratory.thermometers_as_measured_c()[place]; }

  VirtualLaboratory laboratory{laboratory_of_rig("virtual"), {}};
  DconSession session{laboratory,
                      {{.address = 0x04, .inputs = {0, 1, 2, 3, 4, 5, 6, 7}},
                       {.address = 0x1F, .checksum = drivers::DconChecksum::on, .inputs = {8}}}};
  const std::vector<drivers::TemperatureRange> ranges{8, *drivers::dcon_range(0x10)};
};

TEST_F(DconSessionTest, ReportsSettingsAndName) {
  EXPECT_EQ(ask(session, "$042\r"), "!04100600\r");
  EXPECT_EQ(ask(session, "$04M\r"), "!047018\r");
  EXPECT_EQ(ask(session, "$046\r"), "!04FF\r");
}

TEST_F(DconSessionTest, ReadsAllInputsOrOne) {
  const auto reply = ask(session, "#04\r");
  ASSERT_TRUE(reply.ends_with('\r'));
  const auto readings = decode_dcon_readings(reply.substr(0, reply.size() - 1), 4, ranges);
  ASSERT_TRUE(readings) << text(readings.error());
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR((*readings)[i]->value, reading_c(i), 0.005) << i;
  EXPECT_NEAR(std::stod(ask(session, "#043\r").substr(1)), reading_c(3), 0.005);
}

TEST_F(DconSessionTest, AnswersOnlyAtModuleAddress) {
  EXPECT_EQ(ask(session, "$052\r"), "");
  EXPECT_EQ(ask(session, "#1F\r"), "") << "the checksum is missing";
  const auto reply = ask(session, seal_dcon("#1F", drivers::DconChecksum::on) + "\r");
  const auto line = unseal_dcon(std::string_view(reply).substr(0, reply.size() - 1), drivers::DconChecksum::on);
  ASSERT_TRUE(line) << reply;
  const auto readings = decode_dcon_readings(*line, 0x1F, ranges);
  ASSERT_TRUE(readings);
  EXPECT_NEAR((*readings)[0]->value, reading_c(8), 0.005);
  EXPECT_EQ((*readings)[1].error().kind, FaultKind::out_of_range) << "an open wire";
}

TEST_F(DconSessionTest, DistinguishesInvalidAndUnknownCommand) {
  EXPECT_EQ(ask(session, "$04B\r"), "?04\r");
  for (const char* command : {"\r", "#\r", "#0\r", "#049\r", "hello\r", "%0401\r", "#g4\r"})
    EXPECT_EQ(ask(session, command), "") << command;
  EXPECT_EQ(ask(session, std::string(100000, '#') + "\r"), "");
  EXPECT_EQ(ask(session, "$04"), "");
  EXPECT_EQ(ask(session, "2\r"), "!04100600\r");
}

}  // namespace
}  // namespace gyrotherm::simulator
