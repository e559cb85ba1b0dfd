// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/run_goal.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "analysis/population/type_prior.hpp"
#include "core/file.hpp"
#include "core/shipped.hpp"
#include "sequencer/profile/released_blocks.hpp"

namespace gyrotherm::app {
namespace {

constexpr Duration kGoalCluster = std::chrono::seconds(100);

constexpr const char* kMissingUntil =
    "the profile has no table [until]; add the released blocks to it:\n"
    "  [until]\n  u_deg_per_h = 0.012\n  mission = \"shipboard\"\n  longest = \"40 h\"\n"
    "  [[until.block]]\n  name = \"cold\"\n  [[until.block.segment]]\n  kind = \"ramp\"\n  …\n"
    "the shipped profile \"until\" is an example";

/// Returns the path of a file that a profile names: relative to the folder of the profile, or a shipped profile.
Result<std::string> find_named_file(const std::string& named, const std::string& profile_path) {
  const std::filesystem::path path(named);
  if (path.is_absolute()) return named;
  const auto beside = std::filesystem::path(parent_folder(profile_path)) / path;
  std::error_code error;
  if (std::filesystem::exists(beside, error)) return beside.string();
  if (is_path(named))
    return failure(FaultKind::bad_file, beside.string(), "does not exist, expected a file beside the profile");
  return resolve_path(named, kShippedProfile);
}

Result<std::string> read_mission(const profile::Until& until, const std::string& profile_path) {
  const auto path = find_named_file(until.mission, profile_path);
  if (!path) return failure(FaultKind::bad_file, until.place, fmt::format("\"mission\": {}", text(path.error())));
  auto mission = read_text_file(*path);
  if (!mission) return failure(FaultKind::bad_file, until.place, fmt::format("\"mission\": {}", text(mission.error())));
  const auto parsed = profile::parse_profile(*mission, *path);
  if (!parsed) return failure(parsed.error());
  if (parsed->until)
    return failure(FaultKind::bad_file, parsed->until->place, "a mission has no [until], expected a fixed program");
  return mission;
}

/// Reads a type prior and returns its text. Fails if it is not one, since the run would find out only at its first
/// decision.
Result<std::string> read_prior(const profile::Until& until, const std::string& profile_path) {
  if (until.prior.empty()) return std::string();
  const auto beside = std::filesystem::path(until.prior).is_absolute()
                          ? until.prior
                          : (std::filesystem::path(parent_folder(profile_path)) / until.prior).string();
  auto prior = read_text_file(beside, kLargestTable);
  if (!prior) return failure(FaultKind::bad_file, until.place, fmt::format("\"prior\": {}", text(prior.error())));
  if (const auto parsed = population::type_prior_from_json(*prior, beside); !parsed) return failure(parsed.error());
  return prior;
}

}  // namespace

Result<std::optional<record::RunInfo::Goal>> read_goal(const profile::Profile& profile, const std::string& given,
                                                       const std::optional<double>& u_deg_per_h) {
  if (!profile.until && u_deg_per_h) return failure(FaultKind::usage, "--until-u", kMissingUntil);
  if (!profile.until) return std::nullopt;
  if (u_deg_per_h && !(std::isfinite(*u_deg_per_h) && *u_deg_per_h > 0))
    return failure(FaultKind::usage, "--until-u", "expected a number of °/h above 0");
  const auto path = resolve_path(given, kShippedProfile);
  if (!path) return failure(path.error());
  auto mission = read_mission(*profile.until, *path);
  if (!mission) return failure(mission.error());
  auto prior = read_prior(*profile.until, *path);
  if (!prior) return failure(prior.error());
  return record::RunInfo::Goal{.u_deg_per_h = u_deg_per_h.value_or(profile.until->u_deg_per_h),
                               .mission_name = profile.until->mission,
                               .mission_text = std::move(*mission),
                               .prior_text = std::move(*prior)};
}

Result<void> check_goal(const profile::Profile& profile, const std::optional<record::RunInfo::Goal>& goal,
                        bool upload) {
  if (!profile.until) return {};
  if (upload)
    return failure(FaultKind::usage, "--upload",
                   "not valid for a profile with [until]: a controller cannot choose the next block");
  if (!goal)
    return failure(FaultKind::usage, profile.name,
                   "a profile with [until] ends by itself; expected it with \"gyrotherm run\"");
  return {};
}

std::string describe_goal(const profile::Profile& profile, const record::RunInfo::Goal& goal) {
  return fmt::format("the run ends by itself: U {:g} °/h wanted on {}, at most {}, {} released blocks",
                     goal.u_deg_per_h, goal.mission_name, format_duration(profile.until->longest),
                     profile.until->blocks.size());
}

planning::ProgramPath program_path(std::span<const profile::Segment> segments, Celsius from) {
  const auto total = profile::total_time(segments);
  const auto count = static_cast<Eigen::Index>(total / kGoalCluster);
  planning::ProgramPath path{.length_s = to_seconds(kGoalCluster),
                             .set_point_c = Eigen::VectorXd::Zero(count),
                             .start = Eigen::VectorXi::Zero(count)};
  Duration now{};
  int start = -1;
  bool was_off = true;
  for (const auto& segment : segments) {
    if (was_off && !segment.unit.off) ++start;
    was_off = segment.unit.off;
    const auto length = shortest(segment);
    for (Duration at{}; at < length; at += kSecond, now += kSecond) {
      const auto row = static_cast<Eigen::Index>(now / kGoalCluster);
      if (row >= count) return path;
      const double done = segment.kind == profile::SegmentKind::ramp ? to_seconds(at) / to_seconds(length) : 1;
      path.set_point_c(row) += (from.value + done * (segment.target.value - from.value)) / path.length_s;
      if (segment.unit.off || path.start(row) < 0)
        path.start(row) = -1;
      else
        path.start(row) = start;
    }
    from = segment.target;
  }
  return path;
}

planning::ProgramPath program_path(const profile::Profile& profile) {
  return program_path(profile.segments, profile.segments.front().target);
}

Result<planning::ProgramPath> mission_path(const record::RunInfo::Goal& goal) {
  const auto mission = profile::parse_profile(goal.mission_text, goal.mission_name + " (mission)");
  if (!mission) return failure(mission.error());
  return program_path(*mission);
}

}  // namespace gyrotherm::app
