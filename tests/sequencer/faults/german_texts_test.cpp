// SPDX-License-Identifier: Apache-2.0
/// Every text that a run with faults records is German in a German report.
#include "tests/sequencer/faults/german_texts.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "tests/sequencer/faults/broken_things.hpp"
#include "tests/sequencer/faults/simulated_run.hpp"

namespace gyrotherm::faults {
namespace {

/// Seconds from the alarm to the end of the test.
constexpr int kLongestWait = 60;

std::string text_folder() { return std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : ::testing::TempDir(); }

void expect_german(const std::set<std::string>& untranslated) {
  for (const auto& text : untranslated) ADD_FAILURE() << text;
}

TEST(GermanTexts, CoverEveryInterlock) {
  std::set<std::string> untranslated, interlocks;
  for (const auto& broken : broken_things()) {
    BreakableRun d(broken.setting);
    d.seconds(broken.at);
    broken.breaks(d);
    d.until([&] { return d.active_alarms().size() > broken.also.size(); }, broken.acts_within);
    d.seconds(kLongestWait);
    for (const auto& [slot, event] : d.record().events) {
      interlocks.insert(event.about.interlock);
      untranslated.insert(find_untranslated(event));
    }
  }
  untranslated.erase("");
  expect_german(untranslated);
  EXPECT_GE(interlocks.size(), interlocks::kInterlocks);
}

/// The texts of the schedules also name the faults of the instruments, the disk and the operators' commands.
TEST(GermanTexts, CoverFaultSchedules) {
  constexpr std::uint64_t kSeeds = 40;
  std::set<std::string> untranslated;
  std::size_t events = 0;
  for (const auto* rig : {"virtual-reference", "virtual-lot"}) {
    const auto ground = simulated_setup("tests/sequencer/faults/hour.toml", rig);
    const auto seeds = std::string(rig) == "virtual-lot" ? kSeeds / 8 : kSeeds;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto report = carry_out(ground, {.seed = seed,
                                             .schedule = draw_schedule(seed, options_for(ground)),
                                             .folder = text_folder(),
                                             .sync_every = sync_every(seed)});
      events += report.events.size();
      for (const auto& event : report.events) untranslated.insert(find_untranslated(event));
    }
  }
  untranslated.erase("");
  expect_german(untranslated);
  EXPECT_GT(events, 1000U);
}

}  // namespace
}  // namespace gyrotherm::faults
