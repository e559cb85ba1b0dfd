// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/servers/asking.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

TEST(ProcessSession, AnswersLikeProcessDriver) {
  const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  ProcessSession session(laboratory, {0, 8});
  EXPECT_EQ(ask(session, "1 hello\n"), "1 gyrotherm-thermometer/1 2 a virtual program\n");
  const auto reply = ask(session, "2 read\n");
  ASSERT_TRUE(reply.starts_with("2 ") && reply.ends_with("\n"));
  const auto readings = drivers::decode_process_readings(std::string_view(reply).substr(2, reply.size() - 3), 2);
  ASSERT_TRUE(readings) << text(readings.error());
  EXPECT_NEAR((*readings)[0]->value, laboratory.thermometers_as_measured_c()[0], 1e-6);
  EXPECT_NEAR((*readings)[1]->value, laboratory.thermometers_as_measured_c()[8], 1e-6);
  for (const char* command : {"\n", "read\n", "3\n", "3 stop\n", "x read\n"}) EXPECT_EQ(ask(session, command), "");
}

}  // namespace
}  // namespace gyrotherm::simulator
