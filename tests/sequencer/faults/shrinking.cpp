// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/shrinking.hpp"

#include <algorithm>
#include <array>

namespace gyrotherm::faults {
namespace {

std::string invariant_name(const std::string& violation) { return violation.substr(0, violation.find(' ')); }

bool breaks(const SimulatedSetup& ground, SimulatedRunSetting setting, Schedule schedule,
            const std::string& invariant) {
  setting.schedule = std::move(schedule);
  const auto report = carry_out(ground, setting);
  return std::ranges::any_of(report.violations,
                             [&](const auto& violation) { return invariant_name(violation) == invariant; });
}

}  // namespace

ScheduleOptions options_for(const SimulatedSetup& ground) {
  Duration planned{};
  for (const auto& segment : ground.profile.segments) planned += shortest(segment);
  if (ground.profile.until) planned = ground.profile.until->longest / 2;
  const auto seconds = planned / std::chrono::seconds(1);
  const bool whole = seconds > 36'000;
  return {.seconds = seconds * 4 / 3,
          .longest = whole ? 7200 : 1200,
          .most = whole ? 24 : 8,
          .units = static_cast<int>(ground.tcp.units.size())};
}

std::int64_t sync_every(std::uint64_t seed) {
  constexpr std::array<std::int64_t, 6> kBatches{60, 7, 60, 1, 60, 300};
  return kBatches[seed / 2 % kBatches.size()];
}

Schedule shrink_schedule(const SimulatedSetup& ground, const SimulatedRunSetting& setting) {
  const auto whole = carry_out(ground, setting);
  auto schedule = setting.schedule;
  if (whole.violations.empty()) return schedule;
  const auto invariant = invariant_name(whole.violations.front());
  for (std::size_t i = schedule.size(); i-- > 0;) {
    auto without = schedule;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    if (breaks(ground, setting, without, invariant)) schedule = std::move(without);
  }
  for (auto& fault : schedule)
    while (fault.lasts > 1) {
      const auto lasted = fault.lasts;
      fault.lasts /= 2;
      if (breaks(ground, setting, schedule, invariant)) continue;
      fault.lasts = lasted;
      break;
    }
  return schedule;
}

}  // namespace gyrotherm::faults
