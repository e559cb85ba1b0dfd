// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquisition/exchange/civil_time.hpp"
#include "acquisition/record/schema.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::exchange {

namespace {

using record::AxisInfo, record::GyroKind, record::UnitInfo;

constexpr auto kFormats = words_in_order<FileFormat::text, FileFormat::netcdf>("text", "ulog", "dataflash", "netcdf");
constexpr Vocabulary<char, 4> kSeparators{{{",", ','}, {";", ';'}, {"\t", '\t'}, {" ", ' '}}};
constexpr Vocabulary<char, 2> kDecimals{{{".", '.'}, {",", ','}}};
constexpr Vocabulary<GyroKind, 2> kKinds{{{"rate", GyroKind::rate}, {"increment", GyroKind::pulse_count}}};
constexpr Vocabulary<bool, 2> kOutOfOrder{{{"refuse", false}, {"skip", true}}};

/// Where the names of a map stand.
struct NamedTables {
  std::vector<TomlTable> thermometers{}, units{};
  std::vector<std::vector<TomlTable>> axes{}, values{};  ///< of each unit
};

ColumnName read_column(const TomlTable& table, bool header) {
  if (header) return {.name = table.text("column")};
  const auto number = table.integer("column");
  if (number < 1) table.mistake("column", "a column of a file without a header is its number from 1");
  return {.number = static_cast<std::size_t>(std::max<std::int64_t>(number, 1))};
}

double read_scale(const TomlTable& table, std::optional<double> fallback) {
  const double scale = table.number("scale", fallback);
  if (table.has("scale") && (scale == 0 || !std::isfinite(scale)))
    table.mistake("scale", "expected a number that is not zero");
  return scale;
}

void read_text_format(const TomlTable& table, ImportMap& map) {
  map.separator = one_of(kSeparators, table, "separator", ",");
  map.decimal = one_of(kDecimals, table, "decimal", ".");
  if (map.decimal == map.separator)
    table.mistake("decimal", "a comma is the separator too, expected another separator or decimal = \".\"");
  map.comment = table.text("comment", "");
  map.missing = table.texts("missing");
  map.header = table.boolean("header", true);
  const auto skip = table.integer("skip", 0);
  if (skip < 0) table.mistake("skip", "expected a number of lines, 0 or more");
  map.skip = static_cast<std::size_t>(std::max<std::int64_t>(skip, 0));
}

Duration read_positive(const TomlTable& table, const char* key) {
  const Duration time = table.duration(key);
  if (time <= Duration{}) table.mistake(key, "expected a time longer than zero");
  return time;
}

void read_since(const TomlTable& table, ImportMap& map) {
  if (!table.has("since")) return;
  const auto time = parse_civil_time(table.text("since"));
  if (!time || !time->zone)
    return table.mistake("since", "expected a time with its zone, like \"2026-03-01T12:00:00Z\"");
  map.since = time->reading - *time->zone;
}

void read_zone(const TomlTable& table, ImportMap& map) {
  if (!table.has("zone")) return;
  map.zone = parse_zone(table.text("zone"));
  if (!map.zone) table.mistake("zone", "expected a zone like \"Z\" or \"+01:00\"");
}

void read_text_time(const TomlTable& table, ImportMap& map) {
  constexpr Vocabulary<Duration, 5> kUnits{{{"s", kSecond},
                                            {"ms", std::chrono::milliseconds(1)},
                                            {"us", std::chrono::microseconds(1)},
                                            {"ns", std::chrono::nanoseconds(1)},
                                            {"iso", Duration{}}}};
  if (table.has("interval")) {
    map.interval = read_positive(table, "interval");
    return;
  }
  map.time = read_column(table, map.header);
  map.time_unit = one_of(kUnits, table, "unit");
  map.time_form = map.time_unit == Duration{} ? TimeForm::civil : TimeForm::number;
  if (map.time_form == TimeForm::civil)
    read_zone(table, map);
  else
    read_since(table, map);
}

void read_time(const TomlTable& table, ImportMap& map) {
  if (map.format == FileFormat::text) read_text_time(table, map);
  if (map.format == FileFormat::netcdf) map.time = ColumnName{.name = table.text("column", "time")};
  if (table.has("every")) map.every = read_positive(table, "every");
  map.skips_out_of_order = one_of(kOutOfOrder, table, "out_of_order", "refuse");
}

std::vector<std::string> read_choice(const TomlTable& table, std::string_view key, const ImportMap& map) {
  auto names = table.texts(key);
  for (const std::string& name : names) {
    if (std::ranges::count(map.thermometers, name) == 0)
      table.mistake(key, fmt::format("\"{}\" is no thermometer of this map", name));
  }
  return names;
}

/// Of all axes.
GyroKind kind_of(const ImportMap& map) { return map.units.front().axes.front().kind; }

ImportMap::ScaledColumn read_scaled(const TomlTable& table, bool header) {
  return {.column = read_column(table, header), .scale = read_scale(table, 1), .offset = table.number("offset", 0)};
}

void read_axis(const TomlTable& table, ImportMap& map, UnitInfo& unit) {
  map.axis_columns.push_back(read_column(table, map.header));
  AxisInfo& axis = unit.axes.emplace_back();
  axis.kind = one_of(kKinds, table, "kind");
  axis.scale = read_scale(table, {});
  if (table.has("earth_rate")) axis.earth_rate = DegreesPerHour{table.number("earth_rate")};
  if (axis.kind != kind_of(map)) table.mistake("kind", "a file's axes are all rates or all increments");
  const bool is_log = map.format == FileFormat::ulog || map.format == FileFormat::dataflash;
  if (is_log && axis.kind == GyroKind::pulse_count)
    table.mistake("kind", "a log's messages may be lost, and increments with them; expected \"rate\"");
}

void read_value(const TomlTable& table, ImportMap& map, UnitInfo& unit) {
  const bool is_temperature = table.boolean("temperature", false);
  unit.values.push_back({.name = table.text("name"),
                         .unit = is_temperature ? "°C" : table.text("unit"),
                         .is_temperature = is_temperature});
  map.value_columns.push_back(read_scaled(table, map.header));
}

void read_gyro(const TomlTable& table, ImportMap& map, NamedTables& tables, bool one_of_several) {
  UnitInfo unit;
  if (one_of_several) unit.name = table.text("name");
  unit.serial_number = table.text("serial_number", "");
  unit.model = table.text("model", "");
  map.units.push_back(std::move(unit));
  UnitInfo& made = map.units.back();
  tables.units.push_back(table);
  const auto axes = table.tables("axis");
  tables.axes.push_back(axes.empty() ? std::vector{table} : axes);
  tables.values.push_back(table.tables("value"));
  if (axes.empty()) read_axis(table, map, made);  // an empty list of axes too: no unit is without one
  for (const TomlTable& axis : axes) {
    read_axis(axis, map, made);
    made.axes.back().name = axis.text("name");
  }
  for (const TomlTable& value : table.tables("value")) read_value(value, map, made);
  if (!one_of_several) return;
  made.gradients = read_choice(table, "thermometers", map);
  made.three_point = read_choice(table, "three_point", map);
}

/// A name that is missing has been told of.
void check_names(const NamedTables& tables, const ImportMap& map) {
  record::RunInfo info;
  info.thermometers = channels_of(map, "");
  info.units = map.units;
  const auto table_of = [&](const record::NameTrouble& trouble) -> const TomlTable& {
    switch (trouble.of) {
      case record::NameTrouble::Of::thermometer: return tables.thermometers[trouble.index];
      case record::NameTrouble::Of::axis: return tables.axes[trouble.unit][trouble.index];
      case record::NameTrouble::Of::value: return tables.values[trouble.unit][trouble.index];
      case record::NameTrouble::Of::unit: break;
    }
    return tables.units[trouble.unit];
  };
  for (const auto& trouble : record::new_name_troubles(info))
    if (const TomlTable& table = table_of(trouble); table.has("name"))
      table.mistake("name", fmt::format("{}: {}", trouble.what, trouble.why));
}

void read_units(const TomlTable& root, ImportMap& map, NamedTables& tables) {
  if (root.is_list("gyro")) {
    for (const TomlTable& table : root.tables("gyro")) read_gyro(table, map, tables, true);
    if (map.units.empty()) root.mistake("gyro", "missing [[gyro]], expected at least one");
    return;
  }
  read_gyro(root.table("gyro"), map, tables, false);
  const TomlTable analysis = root.table("analysis");
  map.units.front().gradients = read_choice(analysis, "gradients", map);
  map.units.front().three_point = read_choice(analysis, "three_point", map);
}

}  // namespace

const char* name(FileFormat format) { return word_of(kFormats, format); }

bool ImportMap::counts_increments() const { return kind_of(*this) == GyroKind::pulse_count; }

std::vector<ColumnName> ImportMap::columns() const {
  std::vector<ColumnName> all;
  for (const auto& thermometer : thermometer_columns) all.push_back(thermometer.column);
  all.insert(all.end(), axis_columns.begin(), axis_columns.end());
  for (const auto& value : value_columns) all.push_back(value.column);
  return all;
}

Result<ImportMap> parse_import_map(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  ImportMap map;
  map.text = text;
  root->expect("schema", kImportSchema);
  map.name = root->text("name");
  root->ignore("title");
  const TomlTable format = root->table("file");
  map.format = one_of(kFormats, format, "format", "text");
  if (map.format == FileFormat::text) read_text_format(format, map);
  read_time(root->table("time"), map);
  NamedTables tables;
  for (const TomlTable& table : root->tables("thermometer")) {
    map.thermometers.push_back(table.text("name"));
    map.thermometer_columns.push_back(read_scaled(table, map.header));
    tables.thermometers.push_back(table);
  }
  read_units(*root, map, tables);
  check_names(tables, map);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return map;
}

Result<ImportMap> load_import_map(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  return parse_import_map(*text, path);
}

std::vector<record::Channel> channels_of(const ImportMap& map, const std::string& instrument) {
  std::vector<record::Channel> channels;
  for (const auto& thermometer : map.thermometers)
    channels.push_back({.name = thermometer, .instrument = instrument, .offset = {}});
  return channels;
}

namespace {

std::string quoted(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 60;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    list += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", plain(names[i]));
  if (names.size() > kMost) list += fmt::format(" and {} more", names.size() - kMost);
  return list;
}

}  // namespace

std::string describe_missing_columns(const std::vector<std::string>& missing, const std::vector<std::string>& there) {
  return fmt::format("no column{} {}, expected one of: {}", missing.size() > 1 ? "s" : "", quoted(missing),
                     quoted(there));
}

}  // namespace gyrotherm::exchange
