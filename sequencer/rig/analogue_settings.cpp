// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/analogue_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "drivers/analogue/modbus_analogue_input.hpp"
#include "drivers/line/line_address.hpp"
#include "sequencer/rig/line_settings.hpp"

namespace gyrotherm::rig {
namespace {

constexpr const char* kCelsius = "°C";
constexpr std::int64_t kMaxInputs = 256;

std::optional<drivers::LinkKind> read_framing(const TomlTable& table) {
  return read_link_keyword(drivers::kLinkKinds, table, "framing");
}
std::optional<drivers::WordOrder> read_word_order(const TomlTable& table) {
  return read_link_keyword(drivers::kWordOrders, table, "word_order");
}

/// Reads the map and selects the link for the line.
Result<drivers::AnalogueMap> read_analogue_map(const TomlTable& table, const std::string& rig_file,
                                               const std::string& line_text, const std::optional<std::string>& known) {
  const auto settings = drivers::read_link_settings(table.table("link"));
  const auto framing = read_framing(table);
  const auto word_order = read_word_order(table);
  const auto named = read_named(table, "map", rig_file, kShippedAnalogueMap, known);
  if (!named) return failure(named.error());
  auto map = drivers::parse_analogue_map(named->text, named->path, word_order);
  const auto line = drivers::parse_line(line_text);
  if (!map || !line) return map;
  auto linked = select_link_for(std::move(map->registers), *line, framing);
  if (!linked) return failure(FaultKind::bad_file, table.location("line"), linked.error().what);
  map->registers = apply_link_settings(std::move(*linked), table, line_text, settings);
  return map;
}

/// Returns the unit under test that `gyro` names, or the rig's only unit if the key is absent. Otherwise records an
/// error and returns nothing.
std::optional<std::size_t> find_unit(const TomlTable& table, const std::vector<UnitSettings>& units) {
  if (!table.has("gyro") && units.size() == 1) return 0;
  const auto name = table.text("gyro");
  const auto found = std::ranges::find_if(units, [&](const auto& unit) { return unit.info.name == name; });
  if (found != units.end()) return static_cast<std::size_t>(found - units.begin());
  if (!name.empty()) table.note_error("gyro", fmt::format("\"{}\" is not one of this rig's gyros", name));
  return std::nullopt;
}

/// Reads one channel and appends its value to the unit. `inputs` is the number of the instrument's inputs, or 0 if it
/// is unknown.
std::optional<AnalogueChannel> read_channel(const TomlTable& table, std::size_t inputs, const std::string& instrument,
                                            std::vector<UnitSettings>& units) {
  AnalogueChannel channel{.name = table.text("name")};
  const auto input =
      whole<std::int64_t>(table, "input", 1, inputs == 0 ? kMaxInputs : static_cast<std::int64_t>(inputs));
  channel.input = static_cast<std::size_t>(input - 1);
  channel.scale = table.number("scale", 1);
  channel.offset = table.number("offset", 0);
  if (channel.scale == 0) table.note_error("scale", "must not be zero");
  record::ValueInfo value{.name = channel.name,
                          .unit = table.text("unit"),
                          .is_temperature = table.boolean("temperature", false),
                          .instrument = fmt::format("{}, input {}", instrument, input)};
  if (value.is_temperature && value.unit != kCelsius)
    table.note_error("unit", fmt::format("a temperature is in \"{}\", not in \"{}\"", kCelsius, value.unit));
  const auto unit = find_unit(table, units);
  if (!unit) return std::nullopt;
  auto& settings = units[*unit];
  if (std::ranges::count(settings.info.values, channel.name, &record::ValueInfo::name) > 0)
    table.note_error("name", fmt::format("\"{}\" is the name of another value of this gyro", channel.name));
  channel.unit = *unit;
  channel.value = settings.analogue_values++;
  settings.info.values.push_back(std::move(value));
  return channel;
}

Result<AnalogueSettings> read_analogue_input(const TomlTable& table, const std::string& rig_file, std::size_t number,
                                             std::vector<UnitSettings>& units,
                                             const std::optional<std::string>& known) {
  AnalogueSettings settings{.line = table.text("line"), .map = {}, .channels = {}};
  check_line(table, settings.line);
  auto map = read_analogue_map(table, rig_file, settings.line, known);
  const auto name = map ? map->registers.name : analogue_title(number - 1);
  const auto channels = table.tables("channel");
  if (channels.empty()) table.note_error("", "missing [[analogue_input.channel]], expected at least one");
  for (const auto& one : channels)
    if (auto channel =
            read_channel(one, map ? map->inputs.size() : 0, fmt::format("{} at {}", name, settings.line), units))
      settings.channels.push_back(std::move(*channel));
  if (!map) return failure(std::move(map.error()));
  settings.map = std::move(*map);
  return settings;
}

}  // namespace

std::string analogue_title(std::size_t index) { return fmt::format("analogue input {}", index + 1); }

Result<std::vector<AnalogueSettings>> read_analogue_inputs(const TomlTable& root, const std::string& rig_file,
                                                           std::vector<UnitSettings>& units,
                                                           const std::vector<std::string>& known) {
  Result<std::vector<AnalogueSettings>> all;
  std::size_t number = 0;
  for (const auto& table : root.tables("analogue_input")) {
    const auto text = number < known.size() ? std::optional(known[number]) : std::nullopt;
    auto settings = read_analogue_input(table, rig_file, ++number, units, text);
    if (!all) continue;
    if (settings)
      all->push_back(std::move(*settings));
    else
      all = failure(std::move(settings.error()));
  }
  return all;
}

std::unique_ptr<drivers::AnalogueInputs> make_analogue_inputs(const AnalogueSettings& settings,
                                                              const std::string& place,
                                                              std::unique_ptr<drivers::Registers> registers,
                                                              std::unique_ptr<drivers::Pauses> pauses) {
  std::vector<std::size_t> used_inputs;
  for (const auto& channel : settings.channels) used_inputs.push_back(channel.input);
  return make_modbus_analogue_inputs(settings.map, std::move(used_inputs), place, std::move(registers),
                                     std::move(pauses));
}

}  // namespace gyrotherm::rig
