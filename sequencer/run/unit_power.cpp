// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/unit_power.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace gyrotherm::run {
namespace {

/// Time after which a run ends although a supply could not be switched off.
constexpr Duration kLongestSwitchOff = std::chrono::seconds(60);

std::string describe(const drivers::OutputReading& reading) {
  return fmt::format("{:.2f} V, {:.3f} A", reading.voltage_v, reading.current_a);
}

const char* state_text(bool is_off) { return is_off ? "off" : "on"; }

/// Returns the first limit that the value violates; empty if there is none.
std::string violated_limit(double value, const rig::PowerLimits& limits, const char* unit) {
  if (limits.lowest && value < *limits.lowest)
    return fmt::format("{:.3f} {} is below {:g} {}", value, unit, *limits.lowest, unit);
  if (limits.highest && value > *limits.highest)
    return fmt::format("{:.3f} {} is above {:g} {}", value, unit, *limits.highest, unit);
  return {};
}

}  // namespace

UnitPower::UnitPower(const rig::RigFile& rig) : rig_(rig), supplies_(rig.supplies.size()) {}

void UnitPower::request(io::InstrumentIo& io, std::size_t index, bool off, bool after_trip) {
  auto& supply = supplies_[index];
  supply = {.must_be_off = off, .is_switching = true};
  const auto on = after_trip ? drivers::PowerDemand::on_after_trip : drivers::PowerDemand::on;
  io.demand_power(index, off ? drivers::PowerDemand::off : on);
}

void UnitPower::begin(io::InstrumentIo& io, const profile::Profile& profile, const profile::ProfileState& state) {
  const auto position = profile_position(profile, state);
  const auto index = static_cast<std::size_t>(position.segment);
  is_off_ = profile.segments[index].unit.off;
  const bool changes = index == 0 || profile.segments[index - 1].unit.off != is_off_;
  for (std::size_t i = 0; i < supplies_.size(); ++i) {
    supplies_[i].must_be_off = is_off_;
    if (position.in_segment == Duration{} && changes) request(io, i, is_off_);
  }
}

void UnitPower::require(io::InstrumentIo& io, bool off) {
  if (std::exchange(is_off_, off) == off) return;
  for (std::size_t i = 0; i < supplies_.size(); ++i) request(io, i, off);
}

void UnitPower::switch_again(io::InstrumentIo& io) {
  for (std::size_t i = 0; i < supplies_.size(); ++i) request(io, i, is_off_, true);
}

void UnitPower::stop(io::InstrumentIo& io) {
  if (std::exchange(has_stopped_, true)) return;
  for (std::size_t i = 0; i < supplies_.size(); ++i)
    if (rig_.supplies[i].is_off_on_stop) request(io, i, true);
}

UnitPower::Report UnitPower::observe(const io::InstrumentIo& io, Duration elapsed) {
  Report report;
  faults_ = {};
  boot_left_ = std::max(boot_left_ - elapsed, Duration{});
  if (has_stopped_) since_stop_ += elapsed;
  const auto& readings = io.supplies();
  for (std::size_t i = 0; i < std::min(supplies_.size(), readings.size()); ++i) observe_supply(i, readings[i], report);
  return report;
}

void UnitPower::observe_supply(std::size_t index, const drivers::SupplyReadings& readings, Report& report) {
  auto& supply = supplies_[index];
  const auto& outputs = rig_.supplies[index].outputs;
  const auto title = rig::supply_title(index);
  const bool is_read = std::ranges::all_of(readings.outputs, [](const auto& output) { return output.has_value(); });
  if (supply.is_switching && (readings.gave_up || (is_read && readings.pending == drivers::PowerDemand::keep))) {
    supply.is_switching = false;
    std::vector<std::string> states;
    for (std::size_t i = 0; i < outputs.size() && is_read; ++i)
      states.push_back(fmt::format("output {} {}", outputs[i].settings.output + 1, describe(*readings.outputs[i])));
    if (!readings.gave_up)
      report.notes.push_back(
          fmt::format("{} is {}: {}", title, state_text(supply.must_be_off), fmt::join(states, "; ")));
    if (!supply.must_be_off) boot_left_ = std::max(boot_left_, rig_.supplies[index].boot);
  }
  if (readings.trouble != supply.trouble && !readings.trouble.empty()) report.faults.push_back(readings.trouble);
  supply.trouble = readings.trouble;
  if (supply.is_switching)
    faults_.not_switched.push_back(
        {title, fmt::format("{} is not switched {} yet{}{}", title, state_text(supply.must_be_off),
                            supply.trouble.empty() ? "" : ": ", supply.trouble)});
  for (std::size_t i = 0; i < outputs.size(); ++i) observe_output(index, outputs[i], readings.outputs[i]);
}

void UnitPower::observe_output(std::size_t index, const rig::SupplyOutput& output,
                               const Result<drivers::OutputReading>& reading) {
  const auto& supply = supplies_[index];
  const auto title = rig::output_title(index, output);
  if (!reading) return faults_.unread.push_back(title);
  if (supply.is_switching) return;
  const auto state = describe(*reading);
  if (!reading->trips.empty())
    return faults_.tripped.push_back(
        {title, fmt::format("{} has tripped: {} ({})", title, fmt::join(reading->trips, ", "), state)});
  if (reading->is_on == supply.must_be_off)
    return faults_.changed.push_back(
        {title, fmt::format("{} was switched {} at its panel or by another program, or was restarted ({})", title,
                            state_text(!reading->is_on), state)});
  if (!reading->is_on) return;
  for (const auto& text : {violated_limit(reading->voltage_v, output.voltage, "V"),
                           violated_limit(reading->current_a, output.current, "A")})
    if (!text.empty()) return faults_.outside.push_back({title, fmt::format("{}: {}", title, text)});
}

std::string UnitPower::wait() const {
  for (std::size_t i = 0; i < supplies_.size(); ++i)
    if (supplies_[i].is_switching)
      return fmt::format("{} is being switched {}", rig::supply_title(i), state_text(supplies_[i].must_be_off));
  return {};
}

bool UnitPower::may_be_silent() const {
  const bool is_off_after_stop =
      has_stopped_ && std::ranges::any_of(rig_.supplies, &rig::SupplySettings::is_off_on_stop);
  return is_off_after_stop || !wait().empty() || boot_left_ > Duration{};
}

bool UnitPower::is_settled() const {
  return !has_stopped_ || since_stop_ >= kLongestSwitchOff || std::ranges::none_of(supplies_, &Supply::is_switching);
}

std::string UnitPower::describe_stop() const {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < supplies_.size() && has_stopped_; ++i)
    if (rig_.supplies[i].is_off_on_stop)
      all.push_back(fmt::format("{} {}", rig::supply_title(i),
                                supplies_[i].is_switching ? "NOT switched off: " + supplies_[i].trouble : "off"));
  return fmt::format("{}", fmt::join(all, ", "));
}

}  // namespace gyrotherm::run
