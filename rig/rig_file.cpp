#include "rig/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/file.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map_words.hpp"
#include "drivers/line/line_address.hpp"
#include "sequencer/interlocks/limits.hpp"

namespace gyrotherm {
namespace {

void check_safe_set_point(const TomlTable& table, const char* key, const RigFile& rig) {
  if (rig.safe_set_point < rig.chamber_limits.lowest || rig.safe_set_point > rig.chamber_limits.highest)
    table.mistake(key, "the safe set point is outside what the chamber can do");
}

CelsiusPerMinute read_fastest(const TomlTable& table, const char* key) {
  const auto rate = table.rate(key);
  if (!(rate > CelsiusPerMinute{0})) table.mistake(key, "expected more than 0 °C/min");
  return rate;
}

void read_chamber(const TomlTable& table, RigFile& rig) {
  rig.chamber_line = table.text("line");
  check_line(table, rig.chamber_line);
  rig.chamber_limits = {
      .lowest = table.celsius("lowest"),
      .highest = table.celsius("highest"),
      .fastest_heating = read_fastest(table, "fastest_heating"),
      .fastest_cooling = read_fastest(table, "fastest_cooling"),
  };
  rig.safe_set_point = table.celsius("safe_set_point");
  rig.limiter = read_limiter(table, rig.chamber_limits.lowest, rig.chamber_limits.highest);
  if (rig.chamber_limits.lowest >= rig.chamber_limits.highest)
    table.mistake("lowest", "the lowest temperature is not below the highest");
  else
    check_safe_set_point(table, "safe_set_point", rig);
}

/// What the word at `key` stands for; nothing if it is not there or "default".
template <class T, std::size_t N>
std::optional<T> said(const Vocabulary<T, N>& words, const TomlTable& table, const char* key) {
  if (!table.has(key) || table.text(key) == "default") return std::nullopt;
  return one_of(words, table, key);
}

/// The map, on the link that suits the line.
Result<RegisterMap> read_map(const TomlTable& chamber, const RigFile& rig, const std::optional<std::string>& known) {
  const auto wanted = said(kLinkKinds, chamber, "framing");
  const auto named = read_named(chamber, "map", rig.file, known);
  if (!named) return failure(named.error());
  auto map = parse_register_map(named->text, named->path, rig.chamber_word_order);
  const auto line = parse_line(rig.chamber_line);
  if (!map || !line) return map;
  auto linked = on_line(std::move(*map), *line, wanted);
  if (!linked) return failure(FaultKind::bad_file, chamber.place("line"), linked.error().what);
  return linked;
}

void read_analysis(const TomlTable& table, const std::set<std::string>& channels, RigFile& rig) {
  rig.gradients = table.texts("gradients");
  rig.three_point = table.texts("three_point");
  for (const auto* key : {"gradients", "three_point"})
    for (const auto& name : key == std::string_view("gradients") ? rig.gradients : rig.three_point)
      if (!channels.contains(name))
        table.mistake(key, fmt::format("\"{}\" is no channel of this rig's thermometers", name));
  if (rig.gradients.size() < 2) table.mistake("gradients", "expected at least two thermometers");
  if (!rig.three_point.empty() && rig.three_point.size() != 3)
    table.mistake("three_point", "expected three thermometers: cathode, anode, shell");
}

/// Where an interlock leaves the chamber.
void read_safe(const TomlTable& table, RigFile& rig) {
  rig.safe_set_point = table.celsius("set_point", rig.safe_set_point);
  rig.safe_off = table.boolean("off", false);
  if (table.has("set_point")) check_safe_set_point(table, "set_point", rig);
}

std::vector<std::string> names_of(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const auto& channel : channels) names.push_back(channel.name);
  return names;
}

/// Of the thermometers without which nothing can be trained on the record.
std::vector<std::size_t> columns_of_analysis(const RigFile& rig) {
  std::vector<std::size_t> columns;
  const auto& channels = rig.limits.channels;
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (std::ranges::count(rig.gradients, channels[i]) + std::ranges::count(rig.three_point, channels[i]) > 0)
      columns.push_back(i);
  return columns;
}

/// All lines virtual, or none.
void settle_simulated(const TomlTable& root, RigFile& rig) {
  std::vector<std::string> lines{rig.chamber_line, rig.gyro.line};
  for (const auto& settings : rig.thermometers) lines.push_back(settings.line);
  const auto count = std::count(lines.begin(), lines.end(), kVirtualLine);
  rig.simulated = count == static_cast<std::ptrdiff_t>(lines.size());
  if (count != 0 && !rig.simulated)
    root.mistake("chamber", "some lines are \"virtual\" and some are not; a rig is wholly virtual or wholly real");
  if (rig.simulated != root.has("virtual"))
    root.mistake("virtual",
                 rig.simulated ? "a virtual rig needs a [virtual] table" : "a real rig has no [virtual] table");
}

}  // namespace

Result<RigFile> parse_rig(std::string_view text, const std::string& file, const NamedTexts& known) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  RigFile rig;
  rig.text = text;
  rig.file = file;
  root->expect("schema", "gyrotherm-rig/1");
  rig.name = root->text("name");
  rig.title = root->text("title", rig.name);
  const auto chamber = root->table("chamber");
  read_chamber(chamber, rig);
  std::set<std::string> seen;
  for (const auto& table : root->tables("thermometer"))
    rig.thermometers.push_back(read_thermometer(table, rig.thermometers.size() + 1, seen));
  if (rig.thermometers.empty()) root->mistake("", "missing [[thermometer]], expected at least one");
  auto gyro = read_gyro(root->table("gyro"), file, known.gyro_stream);
  if (gyro) rig.gyro = std::move(*gyro);
  read_analysis(root->table("analysis"), seen, rig);
  read_safe(root->table("safe"), rig);
  rig.limits = read_limits(*root, names_of(channels_of(rig)), rig.chamber_limits);
  rig.limits.needed_thermometers = columns_of_analysis(rig);
  rig.run_limits = read_run_limits(*root);
  if (gyro)
    settle_simulated(*root, rig);
  else
    root->ignore("virtual");
  rig.chamber_word_order = said(kWordOrders, chamber, "word_order");
  auto map = read_map(chamber, rig, known.chamber_map);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  if (!gyro) return failure(gyro.error());
  if (!map) return failure(map.error());
  rig.chamber_map = std::move(*map);
  if (!rig.simulated) return rig;
  auto gyro_model = gyro_model_of(text, file, known.gyro_model);
  if (!gyro_model) return failure(gyro_model.error());
  rig.gyro_model = std::move(*gyro_model);
  return rig;
}

Result<RigFile> read_rig(const std::string& file) {
  const auto text = read_text_file(file);
  if (!text) return failure(text.error());
  return parse_rig(*text, file);
}

std::vector<Channel> channels_of(const RigFile& rig) {
  std::vector<Channel> channels;
  for (const auto& settings : rig.thermometers)
    channels.insert(channels.end(), settings.calibrated.begin(), settings.calibrated.end());
  return channels;
}

}  // namespace gyrotherm
