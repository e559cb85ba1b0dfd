#include "tests/sequencer/faults/reduction.hpp"

#include <algorithm>
#include <array>

namespace gyrotherm {
namespace {

std::string law_of(const std::string& violation) { return violation.substr(0, violation.find(' ')); }

bool breaks(const TrialGround& ground, TrialSetting setting, Schedule schedule, const std::string& law) {
  setting.schedule = std::move(schedule);
  const auto report = carry_out(ground, setting);
  return std::ranges::any_of(report.violations, [&](const auto& violation) { return law_of(violation) == law; });
}

}  // namespace

ScheduleOptions options_for(const Profile& profile) {
  Duration planned{};
  for (const auto& segment : profile.segments) planned += shortest(segment);
  const auto seconds = planned / std::chrono::seconds(1);
  const bool whole = seconds > 36'000;
  return {.seconds = seconds * 4 / 3, .longest = whole ? 7200 : 1200, .most = whole ? 24 : 8};
}

std::int64_t sync_every(std::uint64_t seed) {
  constexpr std::array<std::int64_t, 6> kBatches{60, 7, 60, 1, 60, 300};
  return kBatches[seed / 2 % kBatches.size()];
}

Schedule reduced(const TrialGround& ground, const TrialSetting& setting) {
  const auto whole = carry_out(ground, setting);
  auto schedule = setting.schedule;
  if (whole.violations.empty()) return schedule;
  const auto law = law_of(whole.violations.front());
  for (std::size_t i = schedule.size(); i-- > 0;) {
    auto without = schedule;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    if (breaks(ground, setting, without, law)) schedule = std::move(without);
  }
  for (auto& mishap : schedule)
    while (mishap.lasts > 1) {
      const auto lasted = mishap.lasts;
      mishap.lasts /= 2;
      if (breaks(ground, setting, schedule, law)) continue;
      mishap.lasts = lasted;
      break;
    }
  return schedule;
}

}  // namespace gyrotherm
