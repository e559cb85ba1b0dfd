// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

class Lakeshore218SessionTest : public testing::Test {
 protected:
  std::string ask(std::string_view text) {
    std::vector<std::byte> reply;
    EXPECT_TRUE(session.feed(std::as_bytes(std::span(text)), reply));
    return {reinterpret_cast<const char*>(reply.data()), reply.size()};
  }
  [[nodiscard]] double reading_c(std::size_t place) const { return laboratory.thermometers_as_measured_c()[place]; }

  VirtualLaboratory laboratory{laboratory_of_rig("virtual"), {}};
  Lakeshore218Session session{laboratory, {0, 1, 2, 3, 4, 5, 6, 8}};
};

TEST_F(Lakeshore218SessionTest, ReportsIdentity) { EXPECT_EQ(ask("*IDN?\r\n"), "LSCI,MODEL218S,VIRTUAL1,010126\r\n"); }

TEST_F(Lakeshore218SessionTest, ReadsAllInputsInOrder) {
  const auto reply = ask("CRDG? 0\r\n");
  ASSERT_TRUE(reply.ends_with("\r\n"));
  const auto readings = drivers::decode_crdg(reply.substr(0, reply.size() - 2));
  ASSERT_TRUE(readings);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR((*readings)[i]->value, reading_c(i), 0.0005) << i;
  EXPECT_NEAR((*readings)[7]->value, reading_c(8), 0.0005);
  EXPECT_EQ(ask("CRDG?\r\n"), reply);
}

TEST_F(Lakeshore218SessionTest, ReadsOneInputWithSignAndThreeDecimals) {
  EXPECT_NEAR(std::stod(ask("CRDG? 8\r\n")), reading_c(8), 0.0005);
  EXPECT_NEAR(std::stod(ask("KRDG? 1\r\n")), reading_c(0) + 273.15, 0.0005);
  EXPECT_EQ(ask("CRDG? 1\r\n"), fmt::format("{:+08.3f}\r\n", reading_c(0)));
}

TEST_F(Lakeshore218SessionTest, IgnoresUnknownCommands) {
  for (const char* command : {"CRDG? 9\r\n", "CRDG? x\r\n", "HELLO\r\n", "\r\n", "crdg? 0\r\n"}) {
    EXPECT_EQ(ask(command), "") << command;
  }
}

TEST_F(Lakeshore218SessionTest, SkipsTooLongCommand) {
  EXPECT_EQ(ask(std::string(100000, 'C') + "\n"), "");
  EXPECT_EQ(ask("*IDN?\n"), "LSCI,MODEL218S,VIRTUAL1,010126\r\n");
}

TEST_F(Lakeshore218SessionTest, AcceptsCommandsInAnyPieces) {
  EXPECT_EQ(ask("*ID"), "");
  EXPECT_EQ(ask("N?\r\nCRDG? 1"), "LSCI,MODEL218S,VIRTUAL1,010126\r\n");
  EXPECT_FALSE(ask("\r\n").empty());
}

TEST(Lakeshore218Session, ReadsInputWithoutThermometerAsZeroKelvin) {
  const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  Lakeshore218Session session(laboratory, {8});
  std::vector<std::byte> reply;
  ASSERT_TRUE(session.feed(std::as_bytes(std::span(std::string_view("CRDG? 2\r\n"))), reply));
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(reply.data()), reply.size()), "-273.150\r\n");
}

}  // namespace
}  // namespace gyrotherm::simulator
