// SPDX-License-Identifier: Apache-2.0
#include "rig/inquiry.hpp"

#include <gtest/gtest.h>

#include "rig/rig.hpp"

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

}  // namespace
}  // namespace gyrotherm::rig
