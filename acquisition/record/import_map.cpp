#include "acquisition/record/import_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquisition/record/schema.hpp"
#include "core/file.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm {
namespace {

ColumnName read_column(const TomlTable& table, bool header) {
  if (header) return {.name = table.text("column")};
  const auto number = table.integer("column");
  if (number < 1) table.mistake("column", "a column of a file without a header is its number from 1");
  return {.number = static_cast<std::size_t>(std::max<std::int64_t>(number, 1))};
}

double read_scale(const TomlTable& table, double fallback) {
  const double scale = table.number("scale", fallback);
  if (scale == 0 || !std::isfinite(scale)) table.mistake("scale", "expected a number that is not zero");
  return scale;
}

void read_file_format(const TomlTable& table, ImportMap& map) {
  const std::string separator = table.choice("separator", {",", ";", "\t", " "}, ",");
  if (!separator.empty()) map.separator = separator.front();
  map.comment = table.text("comment", "");
  map.header = table.boolean("header", true);
  const auto skip = table.integer("skip", 0);
  if (skip < 0) table.mistake("skip", "expected a number of lines, 0 or more");
  map.skip = static_cast<std::size_t>(std::max<std::int64_t>(skip, 0));
}

Duration unit_named(const std::string& unit) {
  if (unit == "s") return std::chrono::seconds(1);
  if (unit == "ms") return std::chrono::milliseconds(1);
  if (unit == "us") return std::chrono::microseconds(1);
  return std::chrono::nanoseconds(1);
}

void read_time(const TomlTable& table, ImportMap& map) {
  if (table.has("interval")) {
    map.interval = table.duration("interval");
    if (map.interval <= Duration{}) table.mistake("interval", "expected a time longer than zero");
    return;
  }
  map.time = read_column(table, map.header);
  map.time_unit = unit_named(table.choice("unit", {"s", "ms", "us", "ns"}));
}

ImportMap::ThermometerColumn read_thermometer(const TomlTable& table, bool header) {
  return {.name = table.text("name"),
          .column = read_column(table, header),
          .scale = read_scale(table, 1),
          .offset_c = table.number("offset", 0)};
}

void read_gyro(const TomlTable& table, ImportMap& map) {
  map.gyro = read_column(table, map.header);
  const std::string kind = table.choice("kind", {"rate", "increment"});
  map.gyro_info.kind = kind == "increment" ? GyroKind::pulse_count : GyroKind::rate;
  map.gyro_info.scale = read_scale(table, 0);
  if (table.has("earth_rate")) map.gyro_info.earth_rate = DegreesPerHour{table.number("earth_rate")};
}

std::vector<std::string> read_choice(const TomlTable& table, std::string_view key, const ImportMap& map) {
  auto names = table.texts(key);
  for (const std::string& name : names) {
    const auto same = [&](const auto& thermometer) { return thermometer.name == name; };
    if (std::none_of(map.thermometers.begin(), map.thermometers.end(), same))
      table.mistake(key, fmt::format("\"{}\" is no thermometer of this map", name));
  }
  return names;
}

void check_names(const TomlTable& root, const ImportMap& map) {
  std::vector<Channel> channels;
  for (const auto& thermometer : map.thermometers)
    channels.push_back({.name = thermometer.name, .instrument = "", .offset = {}});
  if (const auto good = check_channel_names(channels); !good) root.mistake("thermometer", text(good.error()));
}

}  // namespace

Result<ImportMap> parse_import_map(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  ImportMap map;
  map.text = text;
  (void)root->choice("schema", {kImportSchema});
  map.name = root->text("name");
  root->ignore("title");
  read_file_format(root->table("file"), map);
  read_time(root->table("time"), map);
  for (const TomlTable& table : root->tables("thermometer"))
    map.thermometers.push_back(read_thermometer(table, map.header));
  check_names(*root, map);
  read_gyro(root->table("gyro"), map);
  const TomlTable analysis = root->table("analysis");
  map.gradients = read_choice(analysis, "gradients", map);
  map.three_point = read_choice(analysis, "three_point", map);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return map;
}

Result<ImportMap> load_import_map(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  return parse_import_map(*text, path);
}

}  // namespace gyrotherm
