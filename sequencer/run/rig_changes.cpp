// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/rig_changes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/run_info.hpp"
#include "sequencer/run/resume.hpp"

namespace gyrotherm::run {
namespace {

/// A channel that is read once a second, and its fault; null if it has none.
struct ChannelReading {
  std::string channel;
  std::string name;
  const Fault* fault;
  bool is_unit = false;
  bool is_dropped = false;
};

std::vector<ChannelReading> read_faults(const Sample& sample, const rig::RigFile& rig,
                                        const std::vector<bool>& dropped) {
  const auto& names = rig.limits.channels;
  const auto of = [](const auto& reading) { return reading.value ? nullptr : &reading.value.error(); };
  std::vector<ChannelReading> faults{{"chamber", "chamber", of(sample.chamber)}};
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i) {
    const std::string channel = i < names.size() ? names[i] : std::to_string(i + 1);
    faults.push_back({channel, "thermometer " + channel, of(sample.thermometers[i])});
  }
  for (std::size_t i = 0; i < sample.units.size(); ++i) {
    const auto& unit = rig.units[i].info.name;
    faults.push_back(
        {unit, unit == record::kOnlyUnit ? unit : "gyro " + unit, of(sample.units[i].count), true, dropped[i]});
    const auto& analogue = sample.units[i].analogue;
    for (std::size_t k = 0; k < analogue.size() && i < rig.limits.units.size(); ++k) {
      const auto channel = analogue_channel(rig.limits.units[i], k);
      faults.push_back({channel, channel, of(analogue[k]), false, dropped[i]});
    }
  }
  return faults;
}

/// Describes a fault. Adds the location that the driver reports if the channel's name does not contain it.
std::string describe(const ChannelReading& channel) {
  const auto& [kind, where, what] = *channel.fault;
  const bool adds_nothing = where.empty() || channel.name.ends_with(where);
  return adds_nothing ? fmt::format("{}: {}", channel.name, what)
                      : fmt::format("{}: {}: {}", channel.name, where, what);
}

}  // namespace

std::vector<RigChange> RigChanges::compare_readings(const Sample& sample, const std::vector<bool>& dropped,
                                                    bool units_may_be_off) {
  std::vector<RigChange> changes;
  const auto channels = read_faults(sample, rig_, dropped);
  is_faulty_.resize(channels.size());
  faulty_readings_ = readings_while_off_ = 0;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& channel = channels[i];
    if (channel.fault != nullptr) ++(channel.is_unit && units_may_be_off ? readings_while_off_ : faulty_readings_);
    if (channel.is_dropped) continue;
    const bool is_faulty = channel.fault != nullptr && !(channel.is_unit && units_may_be_off);
    if (is_faulty && !is_faulty_[i])
      changes.push_back({EventKind::fault, describe(channel), {.channel = channel.channel}});
    if (!is_faulty && is_faulty_[i])
      changes.push_back({EventKind::recovered, channel.name + " answers again", {.channel = channel.channel}});
    is_faulty_[i] = is_faulty;
  }
  if (sample.chamber.value && sample.chamber.value->alarms != chamber_alarms_) {
    chamber_alarms_ = sample.chamber.value->alarms;
    const bool is_over = chamber_alarms_.empty();
    changes.push_back({is_over ? EventKind::recovered : EventKind::fault,
                       is_over ? "chamber: all alarms have cleared"
                               : fmt::format("chamber alarm: {}", fmt::join(chamber_alarms_, "; ")),
                       {.channel = "chamber"}});
  }
  return changes;
}

std::vector<RigChange> RigChanges::compare_alarms(const interlocks::InterlockResult& result, const Sample& sample,
                                                  Duration missed) {
  std::vector<RigChange> changes;
  auto found = find_roots(lines_, std::move(roots_),
                          {.sample = sample,
                           .missed = missed,
                           .longest_missed = kLongestUnattended,
                           .clear_after = rig_.limits.clear_after,
                           .raised = result.raised});
  roots_ = std::move(found.memory);
  const auto* warn = name(interlocks::Reaction::warn);
  for (const auto& root : found.raised)
    changes.push_back({EventKind::fault,
                       fmt::format("{} ({}): {}", root.id, warn, root.text),
                       {.interlock = root.id, .reaction = warn, .channel = root.subject}});
  for (std::size_t i = 0; i < result.raised.size(); ++i) {
    const auto& alarm = result.raised[i];
    const auto& root = found.roots[i];
    changes.push_back({alarm.reaction > interlocks::Reaction::warn ? EventKind::interlock : EventKind::fault,
                       fmt::format("{} ({}): {}{}", name(alarm.id), name(alarm.reaction), alarm.text,
                                   root.empty() ? "" : record::consequence_suffix(root)),
                       {.interlock = name(alarm.id), .reaction = name(alarm.reaction), .channel = alarm.subject}});
  }
  for (const auto& alarm : result.cleared)
    changes.push_back({EventKind::recovered,
                       fmt::format("{} is over; its cause was: {}", name(alarm.id), alarm.text),
                       {.interlock = name(alarm.id), .reaction = name(alarm.reaction), .channel = alarm.subject}});
  for (const auto& root : found.cleared)
    changes.push_back({EventKind::recovered,
                       fmt::format("{} is over; its cause was: {}", root.id, root.text),
                       {.interlock = root.id, .reaction = name(interlocks::Reaction::go_on), .channel = root.subject}});
  return changes;
}

}  // namespace gyrotherm::run
