// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/toml_reader.hpp"
#include "sequencer/profile/expansion.hpp"
#include "sequencer/profile/written_profile.hpp"

namespace gyrotherm::profile {
namespace {

constexpr const char* kSchema = "gyrotherm-profile/1";

/// `prefix.key = number`, however deep the tables: both "a.b" = 1 and a.b = 1 are the path a.b.
void read_accept(const TomlTable& table, const std::string& prefix, std::vector<AcceptLimit>& limits) {
  for (const auto& key : table.keys()) {
    if (table.is_table(key))
      read_accept(table.table(key), prefix + key + ".", limits);
    else
      limits.push_back({prefix + key, table.number(key)});
  }
}

constexpr CelsiusPerMinute kRounding{1e-9};

constexpr std::size_t kMostMistakes = 100;  ///< that are told of one profile

/// The mistakes found so far; the passes of a repeat make each but once.
class Mistakes {
 public:
  void note(const Segment& segment, std::string what) {
    if (found_.size() == kMostMistakes) return;
    std::pair mistake{segment.place, std::move(what)};
    if (std::find(found_.begin(), found_.end(), mistake) == found_.end()) found_.push_back(std::move(mistake));
  }

  [[nodiscard]] Result<void> verdict() const {
    if (found_.empty()) return {};
    std::string what = found_.front().second;
    for (std::size_t i = 1; i < found_.size(); ++i) what += fmt::format("\n{}: {}", found_[i].first, found_[i].second);
    if (found_.size() == kMostMistakes) what += fmt::format("\nno more than {} mistakes are told", kMostMistakes);
    return failure(FaultKind::bad_file, found_.front().first, std::move(what));
  }

 private:
  std::vector<std::pair<std::string, std::string>> found_;
};

void check_temperature(const Segment& segment, const ChamberLimits& limits, Mistakes& mistakes) {
  if (segment.target >= limits.lowest && segment.target <= limits.highest) return;
  mistakes.note(segment, fmt::format("{:g} °C is beyond the chamber, expected {:g} to {:g} °C", segment.target.value,
                                     limits.lowest.value, limits.highest.value));
}

void check_rate(const Segment& segment, Celsius from, const ChamberLimits& limits, Mistakes& mistakes) {
  const bool heating = segment.target > from;
  const auto fastest = heating ? limits.fastest_heating : limits.fastest_cooling;
  if (segment.rate.value <= fastest.value + kRounding.value) return;
  mistakes.note(segment, fmt::format("{:g} °C/min is faster than the chamber {}, expected at most {:g} °C/min",
                                     segment.rate.value, heating ? "heats" : "cools", fastest.value));
}

void check_deadline(const Segment& segment, Mistakes& mistakes) {
  if (segment.deadline >= shortest(segment)) return;
  mistakes.note(segment,
                fmt::format("deadline too short: {:.0f} s, expected at least the {:.0f} s that the segment takes",
                            to_seconds(segment.deadline), to_seconds(shortest(segment))));
}

}  // namespace

Duration shortest(const Segment& segment) {
  return segment.guaranteed_soak ? std::max(segment.duration, segment.soak_time + segment.soak_dwell)
                                 : segment.duration;
}

Celsius set_point_before(const Profile& profile, std::size_t segment) {
  return profile.segments[segment == 0 ? 0 : segment - 1].target;
}

Result<Profile> parse_profile(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  root->expect("schema", kSchema);
  Profile profile;
  profile.text = text;
  profile.name = root->text("name");
  profile.title = root->text("title", profile.name);
  const auto metadata = root->table("metadata");
  for (const auto& key : metadata.keys()) profile.metadata[key] = metadata.text(key);
  read_accept(root->table("accept"), "", profile.accept);
  const auto written = read_segments(*root, read_defaults(root->table("defaults")));
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  expand(written, profile);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return profile;
}

Result<void> check_profile(const Profile& profile, const ChamberLimits& limits) {
  Mistakes mistakes;
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    check_temperature(segment, limits, mistakes);
    if (segment.kind == SegmentKind::ramp) check_rate(segment, set_point_before(profile, i), limits, mistakes);
    check_deadline(segment, mistakes);
  }
  return mistakes.verdict();
}

Result<void> check_sensors(const Profile& profile, const std::vector<std::string>& channels) {
  Mistakes mistakes;
  for (const auto& segment : profile.segments)
    if (segment.kind == SegmentKind::hold && segment.soak_sensor != "air" &&
        std::find(channels.begin(), channels.end(), segment.soak_sensor) == channels.end())
      mistakes.note(segment, fmt::format("soak_sensor is \"{}\", expected \"air\" or a channel of the rig: {}",
                                         segment.soak_sensor, fmt::join(channels, ", ")));
  return mistakes.verdict();
}

}  // namespace gyrotherm::profile
