// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/checked_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/file.hpp"
#include "core/shipped.hpp"
#include "report/report.hpp"
#include "sequencer/profile/released_blocks.hpp"

namespace gyrotherm::app {

Result<profile::Profile> read_profile(const std::string& given, const rig::RigFile* rig) {
  const auto path = resolve_path(given, kShippedProfile);
  if (!path) return failure(path.error());
  const auto profile_text = read_text_file(*path);
  if (!profile_text) return failure(profile_text.error());
  auto profile = parse_checked_profile(rig, *profile_text, *path);
  if (!profile || rig == nullptr) return profile;
  if (auto added = add_warm_ups(*profile, *rig); !added) return failure(std::move(added.error()));
  if (auto checked = check_profile(*profile, rig->chamber_limits); !checked) return failure(std::move(checked.error()));
  return profile;
}

Result<profile::Profile> parse_checked_profile(const rig::RigFile* rig, const std::string& profile_text,
                                               const std::string& name) {
  auto profile = profile::parse_profile(profile_text, name);
  if (!profile) return profile;
  std::vector<Result<void>> verdicts{check_profile(*profile, rig ? rig->chamber_limits : profile::ChamberLimits{})};
  if (rig) {
    const auto& limits = rig->limits;
    if (verdicts.front()) {
      verdicts.push_back(profile::check_run_limits(*profile, "air", limits.air_lowest, limits.air_highest));
      verdicts.push_back(
          profile::check_run_limits(*profile, "thermometer", limits.thermometers_lowest, limits.thermometers_highest));
    }
    verdicts.push_back(profile::check_sensors(*profile, rig->limits.channels));
    verdicts.push_back(
        profile::check_turns(*profile, std::ranges::all_of(rig->units, &rig::UnitSettings::can_be_turned)));
  }
  std::optional<Fault> errors;
  for (const auto& verdict : verdicts)
    if (!verdict && errors)
      errors->what += "\n" + text(verdict.error());
    else if (!verdict)
      errors = verdict.error();
  if (errors) return failure(std::move(*errors));
  if (rig && !rig->supplies.empty())
    return profile::switch_by_supplies(std::move(*profile), list_unfed_units(rig->supplies, rig->units));
  return profile;
}

Result<void> check_controller(const drivers::SetPointRange& limits, const profile::Profile& profile,
                              const rig::RigFile& rig) {
  auto lowest = rig.safe_set_point, highest = rig.safe_set_point;
  each_released(profile, [&](const profile::Segment& segment, Celsius) {
    lowest = std::min(lowest, segment.target);
    highest = std::max(highest, segment.target);
  });
  const auto refuse = [](const char* side, Celsius limit, Celsius required) {
    return failure(
        FaultKind::out_of_range, "chamber",
        fmt::format(
            "its controller rejects set points {} {:g} °C, but the run needs {:g} °C; change its set-point limit", side,
            limit.value, required.value));
  };
  if (limits.lowest && lowest < *limits.lowest) return refuse("below", *limits.lowest, lowest);
  if (limits.highest && highest > *limits.highest) return refuse("above", *limits.highest, highest);
  return {};
}

Result<void> check_accept(const profile::Profile& profile, const std::string& file) {
  for (const profile::AcceptLimit& limit : profile.accept)
    if (const auto checked = report::check_limit(limit.key); !checked)
      return failure(FaultKind::bad_file, file, fmt::format("[accept] \"{}\" is {}", limit.key, checked.error().what));
  return {};
}

}  // namespace gyrotherm::app
