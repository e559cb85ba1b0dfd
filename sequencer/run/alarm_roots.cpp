// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/alarm_roots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "sequencer/rig/line_settings.hpp"

namespace gyrotherm::run {
namespace {

using interlocks::InterlockAlarm;
using interlocks::InterlockId;

constexpr Duration kOneSecond = std::chrono::seconds(1);
constexpr Duration kLateClearTime = std::chrono::minutes(1);   ///< since the last late tick
constexpr Duration kLateAlarmTime = std::chrono::seconds(10);  ///< missed time that raises host_late
constexpr Duration kRootClearDelay = std::chrono::seconds(5);  ///< consequences return before their root

constexpr std::array kSilences{InterlockId::chamber_silent,      InterlockId::thermometers_lost,
                               InterlockId::needed_channel_lost, InterlockId::gyro_silent,
                               InterlockId::unit_silent,         InterlockId::channel_lost};

bool is_silence(InterlockId id) { return std::ranges::find(kSilences, id) != kSilences.end(); }
bool concerns_gyro(InterlockId id) { return id == InterlockId::gyro_silent || id == InterlockId::unit_silent; }

/// Returns the line at an address, or a line of the instrument's own for a virtual one.
RigLine& line_at(std::vector<RigLine>& lines, const std::string& address, const std::string& instrument) {
  const bool is_shared = !address.empty() && address != rig::kVirtualLine;
  const auto& subject = is_shared ? address : instrument;
  const auto found = std::ranges::find(lines, subject, &RigLine::subject);
  if (found != lines.end()) return *found;
  lines.push_back({.subject = subject});
  return lines.back();
}

bool is_unanswered(const auto& value) { return !value && means_no_answer(value.error()); }
bool is_silent_thermometer(const Sample& sample, std::size_t column) {
  return column < sample.thermometers.size() && is_unanswered(sample.thermometers[column].value);
}
bool is_silent_unit(const Sample& sample, std::size_t unit) {
  return unit < sample.units.size() && is_unanswered(sample.units[unit].count.value);
}

/// Returns true if no instrument on the line answered. An invalid answer is one.
bool is_silent(const RigLine& line, const Sample& sample) {
  if (line.has_chamber && !is_unanswered(sample.chamber.value)) return false;
  return std::ranges::all_of(line.thermometers, [&](auto column) { return is_silent_thermometer(sample, column); }) &&
         std::ranges::all_of(line.units, [&](auto unit) { return is_silent_unit(sample, unit); });
}

/// Returns true if an instrument on the line has not finished its reading in its second.
bool is_too_slow(const RigLine& line, const Sample& sample) {
  const auto is_busy = [](const auto& value) { return !value && is_still_busy(value.error()); };
  return (line.has_chamber && is_busy(sample.chamber.value)) ||
         std::ranges::any_of(line.thermometers,
                             [&](auto column) {
                               return column < sample.thermometers.size() && is_busy(sample.thermometers[column].value);
                             }) ||
         std::ranges::any_of(line.units, [&](auto unit) {
           return unit < sample.units.size() && is_busy(sample.units[unit].count.value);
         });
}

/// Returns the lines of all silent instruments that the alarm concerns, or none if one of these lines answers.
std::vector<std::size_t> lost_lines(const InterlockAlarm& alarm, const std::vector<RigLine>& lines,
                                    const std::vector<bool>& silent, const Sample& sample) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& line = lines[i];
    bool concerns = false;
    if (!alarm.subject.empty())
      concerns = std::ranges::find(line.names, alarm.subject) != line.names.end();
    else if (alarm.id == InterlockId::chamber_silent)
      concerns = line.has_chamber;
    else if (concerns_gyro(alarm.id))
      concerns = std::ranges::any_of(line.units, [&](auto unit) { return is_silent_unit(sample, unit); });
    else
      concerns =
          std::ranges::any_of(line.thermometers, [&](auto column) { return is_silent_thermometer(sample, column); });
    if (!concerns) continue;
    if (!silent[i] || !line.can_be_root()) return {};
    found.push_back(i);
  }
  return found;
}

std::string line_tag(const RigLine& line) { return fmt::format("{} {}", kLineLost, line.subject); }

void step_host(RootResult& result, const RootInputs& inputs) {
  auto& memory = result.memory;
  const bool slept = inputs.missed > inputs.longest_missed;
  if (inputs.missed > Duration{} && !slept) {
    memory.since_late = Duration{};
    memory.late += inputs.missed;
  } else if (memory.since_late) {
    *memory.since_late += kOneSecond;
  }
  if (!memory.since_late || *memory.since_late <= kLateClearTime) return;
  memory.since_late.reset();
  memory.late = {};
  if (std::exchange(memory.host_raised, false)) result.cleared.push_back({kHostLate, "", "the program is on time"});
}

void raise_host(RootResult& result) {
  if (std::exchange(result.memory.host_raised, true)) return;
  result.raised.push_back(
      {kHostLate, "", fmt::format("the machine is too busy: {} without a tick", format_duration(result.memory.late))});
}

void step_lines(RootResult& result, const std::vector<RigLine>& lines, const std::vector<bool>& silent,
                Duration clear_after) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    auto& line = result.memory.lines[i];
    line.answers = silent[i] ? Duration{} : line.answers + kOneSecond;
    if (!line.raised || line.answers < clear_after + kRootClearDelay) continue;
    line.raised = false;
    result.cleared.push_back({kLineLost, lines[i].subject, lines[i].subject + " answers"});
  }
}

}  // namespace

std::vector<RigLine> rig_lines(const rig::RigFile& rig) {
  std::vector<RigLine> lines;
  line_at(lines, rig.chamber_line, "chamber").has_chamber = true;
  std::size_t column = 0;
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i) {
    const auto instrument = fmt::format("thermometer {}", i + 1);
    auto& line = line_at(lines, rig.thermometers[i].line, instrument);
    line.names.push_back(instrument);
    for (const auto& channel : rig.thermometers[i].channels) {
      line.names.push_back(channel);
      line.thermometers.push_back(column++);
    }
  }
  for (const auto& gyro : rig.gyro_lines) {
    auto& line = line_at(lines, gyro.line, line_title(gyro, rig.units));
    for (const auto& share : gyro.shares) {
      line.units.push_back(share.unit);
      line.names.push_back(rig.units[share.unit].info.name);
    }
  }
  return lines;
}

RootResult find_roots(const std::vector<RigLine>& lines, RootMemory memory, const RootInputs& inputs) {
  RootResult result{.memory = std::move(memory), .raised = {}, .cleared = {}, .roots = {}};
  result.memory.lines.resize(lines.size());
  std::vector<bool> silent;
  for (const auto& line : lines) silent.push_back(is_silent(line, inputs.sample));
  step_host(result, inputs);
  step_lines(result, lines, silent, inputs.clear_after);
  for (const auto& alarm : inputs.raised) {
    auto& root = result.roots.emplace_back();
    if (!is_silence(alarm.id)) continue;
    if (result.memory.since_late) {
      raise_host(result);
      root = kHostLate;
      continue;
    }
    for (const auto i : lost_lines(alarm, lines, silent, inputs.sample)) {
      if (root.empty()) root = line_tag(lines[i]);
      if (std::exchange(result.memory.lines[i].raised, true)) continue;
      result.raised.push_back({kLineLost, lines[i].subject,
                               fmt::format("no instrument on {} answers{}", lines[i].subject,
                                           is_too_slow(lines[i], inputs.sample) ? " within its second" : "")});
    }
  }
  if (result.memory.late >= kLateAlarmTime) raise_host(result);
  return result;
}

}  // namespace gyrotherm::run
