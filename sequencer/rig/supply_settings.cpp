// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/supply_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "core/file.hpp"
#include "core/shipped.hpp"
#include "drivers/chamber/text_file_reader.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "sequencer/rig/line_settings.hpp"

namespace gyrotherm::rig {
namespace {

constexpr const char* kUsualOutputName = "supply";
constexpr Duration kUsualBoot = std::chrono::seconds(10), kLongestBoot = std::chrono::minutes(30);

std::vector<drivers::OutputSettings> output_settings(const SupplySettings& supply) {
  std::vector<drivers::OutputSettings> all;
  for (const auto& output : supply.outputs) all.push_back(output.settings);
  return all;
}

Result<drivers::SupplyDescription> read_supply_description(const TomlTable& table, const std::string& rig_file,
                                                           const std::string& line_text,
                                                           const std::optional<std::string>& known) {
  const auto named = read_named(table, "description", rig_file, kShippedSupply, known);
  if (!named) return failure(named.error());
  const auto parameters = drivers::read_text_parameters(table.table("parameter"));
  auto description = drivers::parse_supply_description(named->text, named->path, parameters);
  if (description) note_unknown_parameter(description->unit, table, parameters);
  const auto line = drivers::parse_line(line_text);
  if (!description || !line) return description;
  auto linked = select_link_for(std::move(description->unit), *line);
  if (!linked) return failure(FaultKind::bad_file, table.location("line"), linked.error().what);
  description->unit =
      apply_link_settings(std::move(*linked), table, line_text, drivers::read_line_settings(table.table("link")));
  return description;
}

/// Reads a number above zero.
double read_required_level(const TomlTable& table, const char* key) {
  const double level = table.number(key);
  if (table.has(key) && !(level > 0)) table.note_error(key, "expected a number above zero");
  return level;
}

std::optional<double> read_level_if_any(const TomlTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  return read_required_level(table, key);
}

std::optional<double> read_number_if_any(const TomlTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  return table.number(key);
}

/// Records an error unless the lower limit is below the upper one.
void check_order(const TomlTable& table, const PowerLimits& limits, const char* lowest) {
  if (limits.lowest && limits.highest && !(*limits.lowest < *limits.highest))
    table.note_error(lowest, "the lower limit is not below the upper one");
}

/// Records an error if the set voltage, at which the output is on, is outside its own limits.
void check_power_limits(const TomlTable& table, const SupplyOutput& output) {
  const double voltage_v = output.settings.voltage_v;
  if (output.voltage.lowest && voltage_v < *output.voltage.lowest)
    table.note_error("lowest_v", "the set voltage is below this limit");
  if (output.voltage.highest && voltage_v > *output.voltage.highest)
    table.note_error("highest_v", "the set voltage is above this limit");
}

/// Returns the units that the output feeds: those in `gyros`, or the only one of the rig.
std::vector<std::size_t> read_fed_units(const TomlTable& table, const std::vector<UnitSettings>& units) {
  if (!table.has("gyros") && units.size() == 1) return {0};
  std::vector<std::size_t> fed;
  const auto names = table.has("gyros") ? table.texts("gyros") : std::vector<std::string>();
  if (names.empty()) table.note_error("gyros", "expected the units that this output feeds");
  for (const auto& name : names) {
    const auto found = std::ranges::find_if(units, [&](const auto& unit) { return unit.info.name == name; });
    const auto unit = static_cast<std::size_t>(found - units.begin());
    if (found == units.end())
      table.note_error("gyros", fmt::format("\"{}\" is not one of this rig's gyros", name));
    else if (std::ranges::count(fed, unit) > 0)
      table.note_error("gyros", fmt::format("\"{}\" is listed twice", name));
    else
      fed.push_back(unit);
  }
  return fed;
}

/// Appends a measured value to a unit and returns its index.
std::size_t add_measured_value(UnitSettings& unit, const TomlTable& table, record::ValueInfo value) {
  if (std::ranges::count(unit.info.values, value.name, &record::ValueInfo::name) > 0)
    table.note_error("name", fmt::format("\"{}\" is the name of another value of the gyro {}; give this output a name",
                                         value.name, unit.info.name));
  unit.info.values.push_back(std::move(value));
  return unit.analogue_values++;
}

SupplyOutput read_supply_output(const TomlTable& table, const std::string& instrument,
                                std::vector<UnitSettings>& units) {
  SupplyOutput output{.settings = {}, .name = table.text("name", kUsualOutputName)};
  const auto number = whole<std::size_t>(table, "output", 1, drivers::kMostSupplyOutputs);
  output.settings = {.output = number - std::min<std::size_t>(number, 1),
                     .voltage_v = read_required_level(table, "voltage_v"),
                     .current_a = read_required_level(table, "current_a"),
                     .over_voltage_v = read_level_if_any(table, "over_voltage_v"),
                     .over_current_a = read_level_if_any(table, "over_current_a")};
  output.voltage = {.lowest = read_number_if_any(table, "lowest_v"), .highest = read_number_if_any(table, "highest_v")};
  output.current = {.lowest = read_number_if_any(table, "lowest_a"), .highest = read_number_if_any(table, "highest_a")};
  check_order(table, output.voltage, "lowest_v");
  check_order(table, output.current, "lowest_a");
  check_power_limits(table, output);
  for (const auto index : read_fed_units(table, units)) {
    const auto source = fmt::format("{}, output {}", instrument, number);
    const auto voltage = add_measured_value(
        units[index], table,
        {.name = output.name + "_voltage_v", .unit = "V", .is_temperature = false, .instrument = source});
    const auto current = add_measured_value(
        units[index], table,
        {.name = output.name + "_current_a", .unit = "A", .is_temperature = false, .instrument = source});
    output.shares.push_back({.unit = index, .voltage = voltage, .current = current});
  }
  return output;
}

Result<SupplySettings> read_supply(const TomlTable& table, const std::string& rig_file, std::size_t number,
                                   std::vector<UnitSettings>& units, const std::optional<std::string>& known) {
  SupplySettings supply{.line = table.text("line"), .description = {}, .outputs = {}};
  check_line(table, supply.line);
  supply.is_off_on_stop = table.choice("on_stop", {"keep", "off"}, "keep") == "off";
  supply.boot = table.duration("boot", kUsualBoot);
  if (supply.boot > kLongestBoot) table.note_error("boot", "expected at most 30 min");
  auto description = read_supply_description(table, rig_file, supply.line, known);
  const auto name = description ? description->unit.vendor + " " + description->unit.name : supply_title(number - 1);
  const auto outputs = table.tables("output");
  if (outputs.empty()) table.note_error("", "missing [[supply.output]], expected at least one");
  std::set<std::size_t> taken;
  for (const auto& one : outputs) {
    auto output = read_supply_output(one, fmt::format("{} at {}", name, supply.line), units);
    if (!taken.insert(output.settings.output).second) one.note_error("output", "this output is listed twice");
    if (description)
      if (const auto why = settings_refusal_reason(*description, output.settings); !why.empty())
        one.note_error("", why);
    supply.outputs.push_back(std::move(output));
  }
  if (!description) return failure(std::move(description.error()));
  supply.description = std::move(*description);
  return supply;
}

}  // namespace

std::string supply_title(std::size_t index) { return fmt::format("supply {}", index + 1); }

std::string output_title(std::size_t supply, const SupplyOutput& output) {
  return fmt::format("{}, output {}", supply_title(supply), output.settings.output + 1);
}

Result<std::vector<SupplySettings>> read_supplies(const TomlTable& root, const std::string& rig_file,
                                                  std::vector<UnitSettings>& units,
                                                  const std::vector<std::string>& known) {
  Result<std::vector<SupplySettings>> all;
  std::size_t number = 0;
  for (const auto& table : root.tables("supply")) {
    const auto text = number < known.size() ? std::optional(known[number]) : std::nullopt;
    auto supply = read_supply(table, rig_file, ++number, units, text);
    if (!all) continue;
    if (supply)
      all->push_back(std::move(*supply));
    else
      all = failure(std::move(supply.error()));
  }
  return all;
}

std::vector<std::string> list_unfed_units(const std::vector<SupplySettings>& supplies,
                                          const std::vector<UnitSettings>& units) {
  std::vector<std::string> unfed;
  for (std::size_t unit = 0; !supplies.empty() && unit < units.size(); ++unit) {
    const bool is_fed = std::ranges::any_of(supplies, [&](const auto& supply) {
      return std::ranges::any_of(supply.outputs, [&](const auto& output) {
        return std::ranges::count(output.shares, unit, &SupplyOutput::Share::unit) > 0;
      });
    });
    if (!is_fed) unfed.push_back(units[unit].info.name);
  }
  return unfed;
}

std::string describe(const SupplySettings& supply, const std::vector<UnitSettings>& units) {
  std::vector<std::string> outputs;
  for (const auto& output : supply.outputs) {
    std::vector<std::string> names;
    for (const auto& share : output.shares) names.push_back(units[share.unit].info.name);
    const auto& settings = output.settings;
    auto text = fmt::format("output {} ({}): {:g} V, {:g} A", settings.output + 1, fmt::join(names, ", "),
                            settings.voltage_v, settings.current_a);
    if (settings.over_voltage_v) text += fmt::format(", trips above {:g} V", *settings.over_voltage_v);
    if (settings.over_current_a) text += fmt::format(", trips above {:g} A", *settings.over_current_a);
    outputs.push_back(std::move(text));
  }
  return fmt::format("{} {} at {}: {}; after an abort {}", supply.description.unit.vendor, supply.description.unit.name,
                     supply.line, fmt::join(outputs, "; "), supply.is_off_on_stop ? "off" : "unchanged");
}

std::unique_ptr<drivers::PowerSupply> make_supply(const SupplySettings& settings, const std::string& place,
                                                  const drivers::Line& line) {
  auto stream = drivers::make_text_stream(line, settings.description.unit);
  return drivers::make_text_supply(settings.description, output_settings(settings), std::move(stream), place);
}

std::unique_ptr<drivers::PowerSupply> make_supply(const SupplySettings& settings, const std::string& place,
                                                  std::unique_ptr<drivers::ByteStream> stream, const Clock* clock) {
  auto description = settings.description;
  auto& wire = description.unit.link.text;
  wire.after_read = wire.after_write = {};
  return drivers::make_text_supply(std::move(description), output_settings(settings), std::move(stream), place, clock);
}

}  // namespace gyrotherm::rig
