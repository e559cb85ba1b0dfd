// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/profile_text.hpp"

#include <fmt/format.h>

#include <chrono>
#include <string_view>

#include "core/text.hpp"

namespace gyrotherm::profile {
namespace {

/// Returns a TOML string with the characters of `text`.
std::string quoted_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : plain(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string comment_lines(std::string_view comment) {
  std::string lines;
  while (!comment.empty()) {
    const auto end = comment.find('\n');
    lines += "# " + plain(comment.substr(0, end)) + "\n";
    comment.remove_prefix(end == std::string_view::npos ? comment.size() : end + 1);
  }
  return lines;
}

std::string time_text(Duration time) { return fmt::format("\"{:.0f} s\"", to_seconds(time)); }

/// Returns the rate of a ramp if it gives the ramp's duration, otherwise the duration.
std::string speed_line(const Segment& ramp, Celsius from) {
  const auto distance = abs(ramp.target - from);
  const auto seconds = std::chrono::ceil<std::chrono::seconds>(distance / ramp.rate);
  if (Duration(seconds) == ramp.duration) return fmt::format("rate = {}\n", ramp.rate.value);
  return fmt::format("time = {}\n", time_text(ramp.duration));
}

std::string soak_lines(const Segment& hold) {
  if (!hold.guaranteed_soak) return "guaranteed_soak = false\n";
  auto lines = fmt::format("guaranteed_soak = true\nsoak_band = {}\nsoak_sensor = {}\nsoak_time = {}\n",
                           hold.soak_band.value, quoted_text(hold.soak_sensor), time_text(hold.soak_time));
  if (hold.soak_dwell > Duration{}) lines += fmt::format("soak_dwell = {}\n", time_text(hold.soak_dwell));
  if (hold.soak_slope.value > 0) lines += fmt::format("soak_slope = {}\n", hold.soak_slope.value);
  return lines;
}

/// Returns the lines for a change of the unit's state, and for the operator's task.
std::string unit_lines(const Segment& hold, const UnitState& before) {
  std::string lines;
  if (hold.unit.off != before.off) lines += fmt::format("power = \"{}\"\n", hold.unit.off ? "off" : "on");
  if (hold.unit.turned != before.turned)
    lines += fmt::format("axis = \"{}\"\n", hold.unit.turned ? "turned" : "as mounted");
  if (hold.has_own_prompt) lines += fmt::format("prompt = {}\n", quoted_text(hold.prompt));
  const bool is_opened_by_default = hold.unit.turned != before.turned;
  if (hold.opens_door != is_opened_by_default)
    lines += fmt::format("door = \"{}\"\n", hold.opens_door ? "opened" : "closed");
  return lines;
}

}  // namespace

std::string write_profile(const ProfileText& profile) {
  auto text = comment_lines(profile.comment) + fmt::format("schema = \"gyrotherm-profile/1\"\nname = {}\ntitle = {}\n",
                                                           quoted_text(profile.name), quoted_text(profile.title));
  Celsius at{};
  UnitState unit{};
  for (const auto& [segment, comment] : profile.segments) {
    text += "\n" + comment_lines(comment) + "[[segment]]\n";
    const bool is_ramp = segment.kind == SegmentKind::ramp;
    text += fmt::format("kind = \"{}\"\nname = {}\n", is_ramp ? "ramp" : "hold", quoted_text(segment.name));
    if (is_ramp)
      text += fmt::format("to = {}\n", segment.target.value) + speed_line(segment, at);
    else
      text += fmt::format("at = {}\ntime = {}\n", segment.target.value, time_text(segment.duration)) +
              soak_lines(segment) + unit_lines(segment, unit);
    text += fmt::format("deadline = {}\n", time_text(segment.deadline));
    at = segment.target;
    unit = segment.unit;
  }
  return text;
}

}  // namespace gyrotherm::profile
