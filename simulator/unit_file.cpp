// SPDX-License-Identifier: Apache-2.0
// The units of a rig file's [virtual] table, their brackets and their own values.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "simulator/laboratory_file.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "simulator/virtual_unit.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr std::size_t kMostAxes = 256;

/// Reads a name. It must not contain a point, which joins names, and must differ from all `others`.
std::string read_name(const TomlTable& table, const std::vector<std::string>& others) {
  auto name = table.text("name");
  if (!table.has("name")) return name;
  if (name.empty() || name.find_first_of(". \t") != std::string::npos)
    table.note_error("name", fmt::format("\"{}\", expected a name without dots and spaces", name));
  if (std::ranges::find(others, name) != others.end())
    table.note_error("name", fmt::format("\"{}\" is listed twice", name));
  return name;
}

template <class Named>
std::vector<std::string> list_names(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const auto& one : all) names.push_back(one.name);
  return names;
}

OutputHop read_hop(const TomlTable& table) {
  OutputHop hop{.at_s = to_seconds(table.duration("at")), .deg_per_h = table.number("deg_per_h")};
  if (table.has("for")) hop.for_s = to_seconds(table.duration("for"));
  return hop;
}

AxisParameters read_axis(const TomlTable& table, const ReadoutParameters& type) {
  AxisParameters axis{.earth_rate_deg_per_h = table.number("earth_rate_deg_per_h"),
                      .crosswise_earth_rate_deg_per_h =
                          table.number("crosswise_earth_rate_deg_per_h", type.crosswise_earth_rate_deg_per_h)};
  if (table.has("hop")) axis.hop = read_hop(table.table("hop"));
  return axis;
}

UnitParameters read_unit(const TomlTable& table, const ReadoutParameters& type,
                         const std::vector<std::string>& others) {
  UnitParameters unit{.name = read_name(table, others), .axes = {}};
  const auto axes = table.tables("axis");
  for (const auto& one : axes) {
    auto axis = read_axis(one, type);
    if (axes.size() > 1 || one.has("name")) axis.name = read_name(one, list_names(unit.axes));
    unit.axes.push_back(std::move(axis));
  }
  if (axes.empty()) {
    table.note_error("axis", "the unit has no axis; add [[virtual.unit.axis]]");
    unit.axes.emplace_back();
  }
  return unit;
}

BracketParameters read_bracket(const TomlTable& table, const std::vector<std::string>& units,
                               std::set<std::size_t>& taken) {
  BracketParameters bracket{
      .units = {}, .share = not_negative(table, "share"), .time_constant_s = time_constant_s(table, "time_constant_s")};
  if (bracket.share > kMostBracketShare)
    table.note_error("share", fmt::format("{}, expected at most {}", bracket.share, kMostBracketShare));
  for (const auto& name : table.texts("units")) {
    const auto found = std::ranges::find(units, name);
    const auto unit = static_cast<std::size_t>(found - units.begin());
    if (found == units.end())
      table.note_error("units", fmt::format("\"{}\" is not one of the units {}", name, fmt::join(units, ", ")));
    else if (!taken.insert(unit).second)
      table.note_error("units", fmt::format("\"{}\" is already on a bracket", name));
    else
      bracket.units.push_back(unit);
  }
  if (bracket.units.empty()) table.note_error("units", "expected at least one unit");
  return bracket;
}

OwnThermometer read_own_temperature(const TomlTable& table) {
  return {.time_constant_s = time_constant_s(table, "time_constant_s"),
          .noise_k = not_negative(table, "noise_k"),
          .resolution_k = not_negative(table, "resolution_k", 0),
          .offset_k = table.number("offset_k", 0)};
}

OwnValue read_value(const TomlTable& table, std::vector<std::string> others) {
  others.emplace_back(kOwnTemperature);
  return {.name = read_name(table, others),
          .at_20_c = table.number("at_20_c"),
          .per_k = table.number("per_k", 0),
          .noise = not_negative(table, "noise", 0)};
}

LoadParameters read_load(const TomlTable& table, std::vector<std::string> units) {
  if (units.empty()) units.emplace_back(kPlainUnit);
  LoadParameters load{.unit = table.has("unit") || units.size() > 1 ? table.text("unit") : units.front(),
                      .ohm_at_20_c = positive(table, "ohm"),
                      .per_k = table.number("per_k", 0)};
  if (std::ranges::count(units, load.unit) == 0)
    table.note_error("unit", fmt::format("\"{}\" is not one of the units {}", load.unit, fmt::join(units, ", ")));
  return load;
}

}  // namespace

bool has_units(const TomlTable& table) { return !table.tables("unit").empty(); }

void read_units(const TomlTable& table, LaboratoryParameters& laboratory) {
  std::size_t axes = 0;
  for (const auto& one : table.tables("unit")) {
    laboratory.units.push_back(read_unit(one, laboratory.gyro, list_names(laboratory.units)));
    axes += laboratory.units.back().axes.size();
    if (axes > kMostAxes) return one.note_error("axis", fmt::format("more than {} axes", kMostAxes));
  }
  std::set<std::size_t> taken;
  for (const auto& one : table.tables("bracket"))
    laboratory.brackets.push_back(read_bracket(one, list_names(laboratory.units), taken));
  if (table.has("own_temperature")) laboratory.own_temperature = read_own_temperature(table.table("own_temperature"));
  for (const auto& one : table.tables("value"))
    laboratory.values.push_back(read_value(one, list_names(laboratory.values)));
  for (const auto& one : table.tables("load")) laboratory.loads.push_back(read_load(one, list_names(laboratory.units)));
}

void assign_failures_to_axes(std::vector<FailingThermometer>& failing, std::vector<UnitParameters>& units) {
  if (units.empty()) return;
  std::vector<AxisParameters*> axes;
  for (auto& unit : units)
    for (auto& axis : unit.axes) axes.push_back(&axis);
  for (auto one : std::exchange(failing, {})) {
    auto& axis = *axes[one.index / kThermalLocations];
    one.index %= kThermalLocations;
    axis.failing.push_back(one);
  }
}

}  // namespace gyrotherm::simulator
