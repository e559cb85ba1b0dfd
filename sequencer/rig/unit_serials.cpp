// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/unit_serials.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "core/serial_number.hpp"
#include "core/text.hpp"

namespace gyrotherm::rig {
namespace {

constexpr const char* kOption = "--unit";

tl::unexpected<Fault> refuse(std::string what) { return failure(FaultKind::usage, kOption, std::move(what)); }

UnitSettings* find_unit(RigFile& rig, std::string_view name) {
  const auto found = std::ranges::find_if(rig.units, [&](const auto& unit) { return unit.info.name == name; });
  return found == rig.units.end() ? nullptr : &*found;
}

bool is_unused(const RigFile& rig, const std::string& name) {
  return std::ranges::count(rig.identification.unused, name) > 0;
}

std::vector<std::string> list_names(const RigFile& rig) {
  std::vector<std::string> names;
  for (const auto& unit : rig.units) names.push_back(unit.info.name);
  return names;
}

Result<void> mark_unused(RigFile& rig, const UnitSettings& unit) {
  const auto& name = unit.info.name;
  if (is_unused(rig, name)) return {};
  if (!unit.info.serial_number.empty())
    return refuse(fmt::format("{} is given as empty, but its serial number is {}", name, unit.info.serial_number));
  if (rig.identification.unused.size() + 1 == rig.units.size())
    return refuse(fmt::format("{} is given as empty, but a run needs at least one unit", name));
  rig.identification.unused.push_back(name);
  return {};
}

/// Describes a serial number of a record: "0042", or "an empty position".
std::string describe_recorded(const record::RunInfo& info, const record::UnitInfo& unit) {
  if (record::is_unused(info, unit.name)) return "an empty position";
  return unit.serial_number.empty() ? "no serial number" : unit.serial_number;
}

}  // namespace

Result<UnitSerial> parse_unit_serial(std::string_view text, const RigFile& rig) {
  const auto names = list_names(rig);
  const auto equals = text.find('=');
  const auto name = std::string(trimmed(text.substr(0, std::min(equals, text.size()))));
  const bool is_named = equals != std::string_view::npos && std::ranges::count(names, name) > 0;
  if (!is_named && (names.size() > 1 || equals != std::string_view::npos)) {
    const auto nearest = find_nearest(name, names);
    const auto meant = nearest.empty() || name.empty() ? "" : fmt::format("; did you mean {}=SERIAL?", nearest);
    return refuse(fmt::format("\"{}\" names no position of this rig, expected POSITION=SERIAL with one of {}{}",
                              plain(text), fmt::join(names, ", "), meant));
  }
  const auto number = is_named ? text.substr(equals + 1) : text;
  UnitSerial serial{.unit = is_named ? name : names.front()};
  if (is_named && trimmed(number, " \t\r\n").empty()) return serial;
  auto parsed = parse_serial_number(number);
  if (!parsed) return refuse(fmt::format("{}: the serial number {}", serial.unit, parsed.error().what));
  serial.serial_number = std::move(*parsed);
  return serial;
}

Result<void> identify_unit(RigFile& rig, const UnitSerial& serial) {
  auto* unit = find_unit(rig, serial.unit);
  if (unit == nullptr) return refuse(fmt::format("\"{}\" is not a position of this rig", plain(serial.unit)));
  if (serial.serial_number.empty()) return mark_unused(rig, *unit);
  if (is_unused(rig, serial.unit))
    return refuse(fmt::format("{} is given as empty and as {}", serial.unit, serial.serial_number));
  auto& own = unit->info.serial_number;
  if (!own.empty() && own != serial.serial_number)
    return refuse(fmt::format("gives {} the serial number {}, but {} gives it {}", serial.unit, serial.serial_number,
                              rig.identification.serial_numbers.contains(serial.unit) ? "an earlier value" : rig.file,
                              own));
  if (own.empty()) rig.identification.serial_numbers[serial.unit] = serial.serial_number;
  own = serial.serial_number;
  auto differ = check_serials_differ(rig);
  if (!differ && rig.identification.serial_numbers.erase(serial.unit) > 0) own.clear();
  return differ;
}

Result<void> check_serials_differ(const RigFile& rig) {
  for (std::size_t i = 0; i < rig.units.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const auto &one = rig.units[k].info, &other = rig.units[i].info;
      if (!one.serial_number.empty() && one.serial_number == other.serial_number)
        return refuse(
            fmt::format("the serial number {} is given to {} and to {}", one.serial_number, one.name, other.name));
    }
  return {};
}

std::vector<std::string> find_unidentified(const RigFile& rig) {
  std::vector<std::string> names;
  for (const auto& unit : list_units_in_use(rig))
    if (unit.serial_number.empty()) names.push_back(unit.name);
  return names;
}

std::vector<record::UnitInfo> list_units_in_use(const RigFile& rig) {
  std::vector<record::UnitInfo> units;
  for (const auto& unit : rig.units)
    if (!is_unused(rig, unit.info.name)) units.push_back(unit.info);
  return units;
}

std::string describe_identification(const RigFile& rig) {
  std::vector<std::string> units;
  for (const auto& unit : list_units_in_use(rig))
    units.push_back(unit.name + " " + (unit.serial_number.empty() ? "without serial number" : unit.serial_number));
  auto text = fmt::format("{}", fmt::join(units, ", "));
  const auto& [order, serials, unused] = rig.identification;
  if (!unused.empty()) text += fmt::format("; {} not used", fmt::join(unused, ", "));
  if (!order.empty()) text += "; order " + order;
  return text;
}

void restore_identification(RigFile& rig, const record::RunInfo& info) {
  rig.identification = {.order_number = info.order_number, .unused = info.unused_units};
  for (const auto& recorded : info.units) {
    auto* unit = find_unit(rig, recorded.name);
    if (unit == nullptr) continue;
    if (unit->info.serial_number != recorded.serial_number)
      rig.identification.serial_numbers[recorded.name] = recorded.serial_number;
    unit->info.serial_number = recorded.serial_number;
    unit->info.model = recorded.model;
  }
}

Result<void> compare_with_record(const UnitSerial& serial, const record::RunInfo& info, const std::string& path) {
  const auto* unit = record::find_unit(info, serial.unit);
  if (unit == nullptr) return refuse(fmt::format("{} has no unit \"{}\"", path, plain(serial.unit)));
  const bool is_same =
      serial.serial_number.empty() ? record::is_unused(info, serial.unit) : unit->serial_number == serial.serial_number;
  if (is_same) return {};
  return refuse(fmt::format("gives {} {}, but {} contains {}; a run keeps the units that it began with", serial.unit,
                            serial.serial_number.empty() ? "as empty" : "the serial number " + serial.serial_number,
                            path, describe_recorded(info, *unit)));
}

}  // namespace gyrotherm::rig
