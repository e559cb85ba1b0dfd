// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/dropped_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace gyrotherm::run {

std::string DroppedUnits::refusal_reason(const control::UnitRequest& request) const {
  const auto found = std::ranges::find(names_, request.unit);
  if (found == names_.end())
    return fmt::format("\"{}\" is not a unit of this run, expected one of {}", request.unit, fmt::join(names_, ", "));
  if (std::ranges::count(unused_, request.unit) > 0)
    return fmt::format("the position {} is empty in this run", request.unit);
  const bool is_dropped = dropped_[static_cast<std::size_t>(found - names_.begin())];
  if (request.drop && is_dropped) return fmt::format("{} is dropped already", request.unit);
  if (!request.drop && !is_dropped) return fmt::format("{} is not dropped", request.unit);
  if (request.drop && std::ranges::count(dropped_, false) < 2)
    return fmt::format("{} is the only unit left; \"stop\" ends the run", request.unit);
  return {};
}

void DroppedUnits::carry_out(const control::UnitRequest& request) {
  for (std::size_t i = 0; i < names_.size(); ++i)
    if (names_[i] == request.unit) dropped_[i] = request.drop;
}

void DroppedUnits::drop(std::span<const std::string> names) {
  for (const auto& name : names) carry_out({.drop = true, .unit = name});
}

void DroppedUnits::clear_readings(Sample& sample) const {
  for (std::size_t i = 0; i < sample.units.size(); ++i) {
    if (!dropped_[i]) continue;
    sample.units[i].count.value = GyroCount{};
    for (auto& analogue : sample.units[i].analogue) analogue.value = std::numeric_limits<double>::quiet_NaN();
  }
}

std::vector<std::string> find_dropped_units(const record::Record& record) {
  std::vector<std::string> dropped;
  for (const auto& [slot, event] : record.events) {
    if (event.kind != EventKind::dropped && event.kind != EventKind::returned) continue;
    std::erase(dropped, event.about.channel);
    if (event.kind == EventKind::dropped) dropped.push_back(event.about.channel);
  }
  return dropped;
}

}  // namespace gyrotherm::run
