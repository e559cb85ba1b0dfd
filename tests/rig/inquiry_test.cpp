// SPDX-License-Identifier: Apache-2.0
#include "rig/inquiry.hpp"

#include <gtest/gtest.h>

#include "core/file.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "rig/rig.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::rig {
namespace {

TEST(Inquiry, RoundTripsAreOrdered) {
  VirtualClock clock;
  int call = 0;
  const auto trips = time_calls([&] { clock.advance(std::chrono::milliseconds(++call == 3 ? 100 : call)); }, clock);
  EXPECT_EQ(call, 10);
  EXPECT_EQ(trips.least, std::chrono::milliseconds(1));
  EXPECT_EQ(trips.median, std::chrono::microseconds(6500));
  EXPECT_EQ(trips.most, std::chrono::milliseconds(100));
  EXPECT_EQ(text(trips), "10 reads: 1.000, 6.500, 100.000 ms (least, median, most)");
}

TEST(Inquiry, TellsWhichAlarmNobodyWatches) {
  const auto map = drivers::parse_register_map(R"(schema = "gyrotherm-chamber/1"
name = "oven"
vendor = "test"
source = "none"
[link]
[[register]]
name = "air_temperature"
address = 1
type = "s16"
[[register]]
name = "set_point"
address = 2
type = "s16"
access = "rw"
[[register]]
name = "door"
address = 3
type = "u16"
codes = { shut = 0, open = 1 }
[[alarm]]
severity = "stop"
register = "door"
is = "open"
)",
                                               "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  auto without_door = std::make_unique<tests::FakeRegisters>();
  without_door->words = {{1, 20}, {2, 20}};
  const auto chamber = make_modbus_chamber(*map, std::move(without_door));
  const auto answer = ask_chamber(*chamber, VirtualClock());
  ASSERT_TRUE(answer) << text(answer.error());
  EXPECT_NE(answer->find("WARNING: not watched, the unit does not have it: door (exception 2, illegal data address)"),
            std::string::npos)
      << *answer;
}

TEST(Inquiry, EveryInstrumentOfTheMixedRigSaysWhoItIsAndWhatItReads) {
  const auto file = read_rig(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-mixed.toml");
  ASSERT_TRUE(file) << text(file.error());
  const auto rig = Rig::assemble(*file, {.seed = {}, .already = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  const auto answers = (*rig)->ask();
  ASSERT_EQ(answers.size(), 4u);
  const auto expect = [&](std::size_t index, const std::string& part) {
    ASSERT_TRUE(answers[index]) << text(answers[index].error());
    EXPECT_NE(answers[index]->find(part), std::string::npos) << *answers[index];
  };
  expect(0, "chamber: ");
  expect(0, "10 reads: ");
  expect(1, "thermometer 1: LSCI,MODEL218");
  expect(2, "shell ");
  expect(3, "gyro: kvh-17xx-a frames, ");
  expect(3, "2 frames seen, 0 lost, 0 bad");
}

TEST(Inquiry, AGyroWithoutAClockIsReadByTheRigs) {
  const std::string place = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-mixed.toml";
  auto rig_text = read_text_file(place).value();
  const std::string was = "kvh-17xx-a.toml";
  rig_text.replace(rig_text.find(was), was.size(), "hg4930.toml");
  const auto file = parse_rig(rig_text, place);
  ASSERT_TRUE(file) << text(file.error());
  const auto rig = Rig::assemble(*file, {.seed = {}, .already = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  const auto answers = (*rig)->ask();
  ASSERT_TRUE(answers.at(3)) << text(answers.at(3).error());
  EXPECT_NE(answers.at(3)->find(" counts in 2.000000 s"), std::string::npos) << *answers.at(3);
}

}  // namespace
}  // namespace gyrotherm::rig
