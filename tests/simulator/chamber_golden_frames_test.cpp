// SPDX-License-Identifier: Apache-2.0
/// Compares the requests of the client with the shipped maps byte by byte with frames of chamber controllers. These are
/// published, or derived from manuals.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/simulator/chamber_on_a_line.hpp"

namespace gyrotherm::simulator {
namespace {

using Words = std::vector<std::uint16_t>;

/// Returns the reply to a request, or "not sent" if the client did not send the request.
std::string reply_to(const ChamberOnALine& line, const std::string& request) {
  const auto found = std::ranges::find(line.heard, request);
  return found == line.heard.end() ? "not sent" : line.said[static_cast<std::size_t>(found - line.heard.begin())];
}

/// Returns the reply to a Modbus TCP request. Both exclude the transaction number.
std::string reply_behind_number(const ChamberOnALine& line, const std::string& request) {
  constexpr std::size_t kNumber = 6;
  for (std::size_t i = 0; i < line.heard.size(); ++i)
    if (line.heard[i].substr(kNumber) == request) return line.said[i].substr(std::min(kNumber, line.said[i].size()));
  return "not sent";
}

TEST(GoldenFrames, MatchEzt570iSetPoint) {
  ChamberOnALine line("csz_ezt570i", drivers::LinkKind::rtu);
  ASSERT_TRUE(line.chamber->send_set_point({20.0}));
  EXPECT_EQ(reply_to(line, "01 06 00 3C 00 C8 48 50"), "01 06 00 3C 00 C8 48 50");
  ASSERT_TRUE(line.chamber->send_set_point({-40.0}));
  EXPECT_EQ(reply_to(line, "01 06 00 3C FE 70 08 42"), "01 06 00 3C FE 70 08 42");
  ASSERT_TRUE(line.chamber->start());
  EXPECT_EQ(reply_to(line, "01 06 00 16 00 01 A9 CE"), "01 06 00 16 00 01 A9 CE");
  ASSERT_TRUE(line.chamber->read());
  EXPECT_NE(reply_to(line, "01 03 00 3C 00 02 04 07"), "not sent");
  EXPECT_NE(reply_to(line, "01 03 00 00 00 3C 45 DB"), "not sent");
}

TEST(EztUnit, ShowsChangedSetPointAtNextReading) {
  ChamberOnALine line("csz_ezt570i", drivers::LinkKind::rtu);
  ASSERT_TRUE(line.chamber->send_set_point({30.0}));
  EXPECT_EQ(line.chamber->read().value().set_point.value, 30.0);
  ASSERT_TRUE(line.chamber->send_set_point({35.0}));
  // An operator changes the set point at the panel.
  line.laboratory.change_set_point({25.0});
  const auto seen = line.chamber->read();
  ASSERT_FALSE(seen);
  EXPECT_EQ(seen.error().kind, FaultKind::mismatch);
  EXPECT_EQ(line.chamber->read().value().set_point.value, 25.0)
      << "the second read returns the set point of the controller";
}

TEST(GoldenFrames, MatchEzt570iValues) {
  const auto map = chamber_map("csz_ezt570i");
  EXPECT_NEAR(decode(*map.find("air_temperature"), Words{0x00EC}).value(), 23.6, 1e-9);
  EXPECT_NEAR(decode(*map.find("set_point"), Words{0x0190}).value(), 40.0, 1e-9);
  const auto& name = map.find("profile_name")->text;
  EXPECT_EQ(decode_text(name, Words{0x4554, 0x5453, 0x3120, 0x3332, 0x2020}), "TEST 123");
  EXPECT_EQ(decode_text(name, Words{0x454A, 0x4453, 0x3232, 0x2041, 0x2020}), "JESD22A");
  EXPECT_EQ(encode_text(name, "JESD22A"), (Words{0x454A, 0x4453, 0x3232, 0x2041, 0x2020}));
  EXPECT_EQ(decode_date(map.find("clock")->date, Words{0x0801, 0x1702, 0x1131, 0x0000}).value(),
            (drivers::CivilTime{2008, 1, 23, 17, 49, 0}));
  EXPECT_EQ(encode_date(map.find("clock")->date, {2008, 1, 23, 17, 49, 0})[1], 0x1703)
      << "the day is a Wednesday; the example "
         "of the manual says Tuesday";
}

TEST(GoldenFrames, MatchSamwon) {
  ChamberOnALine line("samwon_temi", drivers::LinkKind::rtu);
  ASSERT_TRUE(line.chamber->read());
  EXPECT_NE(reply_to(line, "01 03 00 00 00 02 C4 0B"), "not sent");
  EXPECT_NEAR(decode(*line.map.find("air_temperature"), Words{0x00FA}).value(), 25.0, 1e-9);
  const auto registers = line.registers();
  ClockPauses pauses(line.clock);
  drivers::ItemExchange items(line.map, *registers, pauses);
  ASSERT_TRUE(items.write(*line.map.find("pattern"), 2));
  EXPECT_EQ(reply_to(line, "01 06 00 63 00 02 F8 15"), "01 06 00 63 00 02 F8 15");
}

TEST(GoldenFrames, MatchTt5166WithUnitZero) {
  ChamberOnALine line("tt5166", drivers::LinkKind::rtu);
  ASSERT_TRUE(line.chamber->send_set_point({22.0}));
  EXPECT_EQ(reply_to(line, "00 06 00 26 00 DC 68 49"), "00 06 00 26 00 DC 68 49");
  ASSERT_TRUE(line.chamber->start());
  EXPECT_EQ(reply_to(line, "00 05 00 00 FF 00 8D EB"), "00 05 00 00 FF 00 8D EB");
  ASSERT_TRUE(line.chamber->stop());
  EXPECT_EQ(reply_to(line, "00 05 00 01 FF 00 DC 2B"), "00 05 00 01 FF 00 DC 2B");
  const auto state = line.chamber->read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->set_point.value, 22.0) << "the acknowledged set point";
  EXPECT_NE(reply_to(line, "00 03 00 00 00 01 85 DB"), "not sent");
  EXPECT_NEAR(decode(*line.map.find("air_temperature"), Words{0x0898}).value(), 22.0, 1e-9);
  const auto registers = line.registers();
  ClockPauses pauses(line.clock);
  drivers::ItemExchange items(line.map, *registers, pauses);
  ASSERT_TRUE(items.write(*line.map.find("humidity_set_point"), 55));
  EXPECT_NE(reply_to(line, "00 06 00 27 02 26 B8 AA"), "not sent");
  ASSERT_TRUE(items.read(*line.map.find("humidity")));
  EXPECT_NE(reply_to(line, "00 03 00 03 00 01 75 DB"), "not sent");
  EXPECT_NEAR(decode(*line.map.find("humidity"), Words{0x0226}).value(), 55.0, 1e-9) << "tenths of a percent";
}

TEST(GoldenFrames, MatchYinhe) {
  ChamberOnALine line("yinhe", drivers::LinkKind::tcp);
  ASSERT_TRUE(line.chamber->send_set_point({22.0}));
  EXPECT_EQ(reply_behind_number(line, "00 00 00 0B 01 10 06 CE 00 02 04 41 B0 00 00"), "00 00 00 06 01 10 06 CE 00 02");
  ASSERT_TRUE(line.chamber->start());
  EXPECT_NE(reply_behind_number(line, "00 00 00 09 01 10 00 C8 00 01 02 00 01"), "not sent");
  ASSERT_TRUE(line.chamber->read());
  EXPECT_NE(reply_behind_number(line, "00 00 00 06 01 03 00 A0 00 02"), "not sent");
  EXPECT_EQ(decode(*line.map.find("air_temperature"), Words{0x41B0, 0x0000}).value(), 22.0);
}

TEST(GoldenFrames, MatchUmc1200WithSetPointsInOneBlock) {
  auto text = chamber_map("umc1200").text;
  const std::string none = "together_with = { register = \"humidity_set_point\", value = 0 }";
  text.replace(text.find(none), none.size(), "together_with = { register = \"humidity_set_point\", value = 55 }");
  ChamberOnALine line(drivers::parse_register_map(text, "umc1200.toml").value());
  ASSERT_TRUE(line.chamber->send_set_point({22.0}));
  EXPECT_NE(reply_behind_number(line, "00 00 00 0B 00 10 00 2B 00 02 04 00 DC 02 26"), "not sent");
  ASSERT_TRUE(line.chamber->start());
  EXPECT_NE(reply_behind_number(line, "00 00 00 09 00 10 00 2F 00 01 02 00 01"), "not sent");
  ASSERT_TRUE(line.chamber->stop());
  EXPECT_NE(reply_behind_number(line, "00 00 00 09 00 10 00 2F 00 01 02 00 00"), "not sent");
  ASSERT_TRUE(line.chamber->read());
  EXPECT_NE(reply_behind_number(line, "00 00 00 06 00 03 00 00 00 02"), "not sent");
  EXPECT_TRUE(line.map.link.modbus.miscounts_write_replies) << "the published reply to a write contains the length 11";
}

}  // namespace
}  // namespace gyrotherm::simulator
