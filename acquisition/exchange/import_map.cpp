// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/record/schema.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::exchange {

namespace {

using record::AxisInfo, record::GyroKind, record::UnitInfo;

constexpr auto kFormats = make_vocabulary<FileFormat::text, FileFormat::netcdf>("text", "ulog", "dataflash", "netcdf");
constexpr Vocabulary<char, 4> kSeparators{{{",", ','}, {";", ';'}, {"\t", '\t'}, {" ", ' '}}};
constexpr Vocabulary<char, 2> kDecimals{{{".", '.'}, {",", ','}}};
constexpr Vocabulary<GyroKind, 2> kKinds{{{"rate", GyroKind::rate}, {"increment", GyroKind::pulse_count}}};
constexpr auto kOutOfOrder = make_vocabulary<OutOfOrder::refuse, OutOfOrder::shift>("refuse", "skip", "continue");
constexpr Vocabulary<bool, 2> kDamaged{{{"refuse", false}, {"skip", true}}};
constexpr Vocabulary<char, 4> kThousands{{{",", ','}, {".", '.'}, {" ", ' '}, {"'", '\''}}};
constexpr auto kDateOrders = make_vocabulary<DateOrder::year_first, DateOrder::month_first>(
    "year-month-day", "day-month-year", "month-day-year");

/// The tables of a map that contain names.
struct NamedTables {
  std::vector<TomlTable> thermometers{}, units{};
  std::vector<std::vector<TomlTable>> axes{}, values{};  ///< per unit
};

ColumnName read_column(const TomlTable& table, bool header, const char* key = "column") {
  const std::string by_number = std::string(key) + "_number";
  const bool is_numbered = header && table.has(by_number);
  if (is_numbered && table.has(key))
    table.note_error(by_number, fmt::format("{} is given too, expected only one of them", key));
  if (header && !is_numbered) return {.name = table.text(key)};
  const auto number = table.integer(is_numbered ? by_number.c_str() : key);
  if (number < 1) table.note_error(is_numbered ? by_number.c_str() : key, "expected a column number of at least 1");
  return {.number = static_cast<std::size_t>(std::max<std::int64_t>(number, 1))};
}

/// Returns whether two columns are the same one. A missing column, which is an error already, is none.
bool is_same_column(const ColumnName& one, const ColumnName& other) {
  return one.name == other.name && one.number == other.number && (!one.name.empty() || one.number > 0);
}

std::optional<ValidRange> read_valid(const TomlTable& table) {
  if (!table.has("valid")) return std::nullopt;
  const auto bounds = table.numbers("valid");
  if (bounds.size() == 2 && bounds[0] < bounds[1]) return ValidRange{bounds[0], bounds[1]};
  table.note_error("valid", "expected the least and the greatest possible number, like [-60, 120]");
  return std::nullopt;
}

double read_scale(const TomlTable& table, std::optional<double> fallback) {
  const double scale = table.number("scale", fallback);
  if (table.has("scale") && (scale == 0 || !std::isfinite(scale)))
    table.note_error("scale", "expected a number that is not zero");
  return scale;
}

std::size_t read_lines(const TomlTable& table, const char* key) {
  const auto lines = table.integer(key, 0);
  if (lines < 0) table.note_error(key, "expected a number of lines, 0 or more");
  return static_cast<std::size_t>(std::max<std::int64_t>(lines, 0));
}

void read_text_format(const TomlTable& table, ImportMap& map) {
  map.separator = one_of(kSeparators, table, "separator", ",");
  map.decimal = one_of(kDecimals, table, "decimal", ".");
  if (map.decimal == map.separator)
    table.note_error("decimal", "a comma is the separator too, expected another separator or decimal = \".\"");
  map.comment = table.text("comment", "");
  map.missing = table.texts("missing");
  map.header = table.boolean("header", true);
  map.preamble = read_lines(table, "preamble");
  map.skip = read_lines(table, "skip");
  if (table.has("thousands")) map.thousands = one_of(kThousands, table, "thousands");
  if (map.thousands != '\0' && map.thousands == map.decimal)
    table.note_error("thousands", "equals the decimal sign, expected another character");
  map.cell_units = table.texts("cell_units");
  map.leaves_out_damaged = one_of(kDamaged, table, "damaged", "refuse");
  if (!table.has("segment")) return;
  const auto ends = table.texts("segment");
  if (ends.size() != 2 || ends[0].empty() || ends[1].empty())
    return table.note_error("segment",
                            "expected the beginnings of the first and the last line of a header, like "
                            "[\"Channels\", \"***End_of_Header***\"]");
  map.segment_begin = ends[0];
  map.segment_end = ends[1];
}

Duration read_positive(const TomlTable& table, const char* key) {
  const Duration time = table.duration(key);
  if (time <= Duration{}) table.note_error(key, "expected a time longer than zero");
  return time;
}

void read_since(const TomlTable& table, ImportMap& map) {
  if (!table.has("since")) return;
  const auto time = parse_civil_time(table.text("since"));
  if (!time || !time->zone)
    return table.note_error("since", "expected a time with its zone, like \"2026-03-01T12:00:00Z\"");
  map.since = counted_time((time->reading - *time->zone).count(), Duration(1));
}

void read_zone(const TomlTable& table, ImportMap& map) {
  if (!table.has("zone")) return;
  map.zone = parse_zone(table.text("zone"));
  if (!map.zone) table.note_error("zone", "expected a zone like \"Z\" or \"+01:00\"");
}

/// A unit of counted time. If the unit implies a reference instant, `since_days` is that instant in days since 1970.
struct TimeUnit {
  Duration unit{};
  std::optional<std::int64_t> since_days{};
};

constexpr std::int64_t kExcel1900 = -25569, kExcel1904 = -24107, kMatlab = -719529, kGps = 3657;

TimeUnit find_time_unit(const std::string& unit_name) {
  using std::chrono::microseconds, std::chrono::milliseconds, std::chrono::minutes, std::chrono::hours;
  const Duration day = hours(24);
  const std::array<std::pair<const char*, TimeUnit>, 13> units{{{"s", {kSecond}},
                                                                {"ms", {milliseconds(1)}},
                                                                {"us", {microseconds(1)}},
                                                                {"µs", {microseconds(1)}},
                                                                {"ns", {Duration(1)}},
                                                                {"min", {minutes(1)}},
                                                                {"h", {hours(1)}},
                                                                {"d", {day}},
                                                                {"excel", {day, kExcel1900}},
                                                                {"excel-1904", {day, kExcel1904}},
                                                                {"matlab", {day, kMatlab}},
                                                                {"labview", {kSecond, kExcel1904}},
                                                                {"gps", {kSecond, kGps}}}};
  const auto* const found =
      std::ranges::find(units, unit_name, [](const auto& unit) { return std::string(unit.first); });
  return found == units.end() ? TimeUnit{kSecond} : found->second;
}

void read_counted_time(const TomlTable& table, const std::string& unit, ImportMap& map) {
  const TimeUnit counted = find_time_unit(unit);
  map.time_unit = counted.unit;
  constexpr std::int64_t kSecondsOfDay = 86400;
  if (counted.since_days) {
    map.since = CountedTime{*counted.since_days * kSecondsOfDay};
    map.counts_gps = unit == "gps";
    map.counts_local_days = !map.counts_gps && unit != "labview";
    read_zone(table, map);
  } else {
    read_since(table, map);
  }
  if (unit == "gps" && (table.has("week") || table.has("week_number")))
    map.week = read_column(table, map.header, "week");
  if (!table.has("wrap")) return;
  const double wrap = table.number("wrap");
  const auto counted_wrap = counted_time(wrap, map.time_unit);
  const auto period = duration_between({}, counted_wrap);
  if (!(wrap > 0) || (period && *period <= Duration{}))
    return table.note_error("wrap", "expected the number at which the counter wraps around to 0");
  if (!period)
    return table.note_error("wrap", "expected a number of at most ten years; a longer counter needs no wrap");
  map.wrap = counted_wrap;
}

void read_dated_time(const TomlTable& table, ImportMap& map) {
  read_zone(table, map);
  if (map.time_form != TimeForm::date) return;
  map.date_order = one_of(kDateOrders, table, "order");
  if (table.has("clock") || table.has("clock_number")) map.clock = read_column(table, map.header, "clock");
}

void read_text_time(const TomlTable& table, ImportMap& map) {
  constexpr Vocabulary<bool, 2> kOtherClocks{{{"compare", false}, {"ignore", true}}};
  map.ignores_other_clocks = one_of(kOtherClocks, table, "other_clocks", "compare");
  if (table.has("interval")) {
    map.interval = read_positive(table, "interval");
    return;
  }
  if (!table.has("column") && !table.has("column_number") && !table.has("unit")) {
    table.note_error("column",
                     "expected the column of the time and its unit, or interval = \"1 s\" for rows without a "
                     "time");
    return;
  }
  map.time = read_column(table, map.header);
  const std::string unit = table.choice("unit", {"s", "ms", "us", "µs", "ns", "min", "h", "d", "iso", "date", "clock",
                                                 "excel", "excel-1904", "matlab", "labview", "gps"});
  map.time_form = unit == "iso"     ? TimeForm::civil
                  : unit == "date"  ? TimeForm::date
                  : unit == "clock" ? TimeForm::clock
                                    : TimeForm::number;
  if (map.time_form == TimeForm::number) return read_counted_time(table, unit, map);
  if (map.time_form != TimeForm::clock) read_dated_time(table, map);
}

void read_time(const TomlTable& table, ImportMap& map) {
  if (map.format == FileFormat::text) read_text_time(table, map);
  if (map.format == FileFormat::netcdf) {
    map.time = ColumnName{.name = table.text("column", "time")};
    map.file_units = table.text("unit", "");
  }
  if (table.has("every")) map.every = read_positive(table, "every");
  map.out_of_order = one_of(kOutOfOrder, table, "out_of_order", "refuse");
}

std::vector<std::string> read_choice(const TomlTable& table, std::string_view key, const ImportMap& map) {
  auto names = table.texts(key);
  for (const std::string& name : names) {
    if (std::ranges::count(map.thermometers, name) == 0)
      table.note_error(key, fmt::format("\"{}\" is not a thermometer of this map", name));
  }
  return names;
}

/// Returns the kind of all axes of a unit.
GyroKind axis_kind(const UnitInfo& unit) { return unit.axes.front().kind; }

ImportMap::ScaledColumn read_scaled(const TomlTable& table, bool header) {
  return {.column = read_column(table, header),
          .scale = read_scale(table, 1),
          .offset = table.number("offset", 0),
          .valid = read_valid(table)};
}

void read_axis(const TomlTable& table, ImportMap& map, UnitInfo& unit) {
  map.axis_columns.push_back(read_column(table, map.header));
  map.axis_valid.push_back(read_valid(table));
  AxisInfo& axis = unit.axes.emplace_back();
  axis.kind = one_of(kKinds, table, "kind");
  axis.scale = read_scale(table, {});
  if (table.has("earth_rate")) axis.earth_rate = DegreesPerHour{table.number("earth_rate")};
  if (axis.kind != axis_kind(unit)) table.note_error("kind", "a unit's axes are all rates or all increments");
  const bool is_log = map.format == FileFormat::ulog || map.format == FileFormat::dataflash;
  if (is_log && axis.kind == GyroKind::pulse_count)
    table.note_error("kind", "a log's messages may be lost, and increments with them; expected \"rate\"");
}

void read_value(const TomlTable& table, ImportMap& map, UnitInfo& unit) {
  const bool is_temperature = table.boolean("temperature", false);
  unit.values.push_back({.name = table.text("name"),
                         .unit = is_temperature ? "°C" : table.text("unit"),
                         .is_temperature = is_temperature});
  map.value_columns.push_back(read_scaled(table, map.header));
}

/// Reads the column with the counting times of a unit's increments. Returns nothing if the table has none.
std::optional<ColumnName> read_interval_column(const TomlTable& table, const ImportMap& map, const UnitInfo& unit) {
  const char* key = table.has("interval_column") ? "interval_column" : "interval_column_number";
  if (!table.has(key)) return std::nullopt;
  if (axis_kind(unit) != GyroKind::pulse_count)
    table.note_error(key, "only increments are counted over a time; expected kind = \"increment\"");
  const auto column = read_column(table, map.header, "interval_column");
  const auto note = [&](const ColumnName& other, const char* owner) {
    if (is_same_column(other, column))
      table.note_error(key, fmt::format("{} is also that of {}", describe(column), owner));
  };
  if (map.time) note(*map.time, "the time");
  for (const auto& thermometer : map.thermometer_columns) note(thermometer.column, "a thermometer");
  for (const auto& axis : map.axis_columns) note(axis, "an axis");
  for (const auto& value : map.value_columns) note(value.column, "a value");
  return column;
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
  if (axes.empty()) read_axis(table, map, made);  // no unit is without an axis
  for (const TomlTable& axis : axes) {
    read_axis(axis, map, made);
    made.axes.back().name = axis.text("name");
  }
  for (const TomlTable& value : table.tables("value")) read_value(value, map, made);
  map.interval_columns.push_back(read_interval_column(table, map, made));
  if (!one_of_several) return;
  made.gradients = read_choice(table, "thermometers", map);
  made.three_point = read_choice(table, "three_point", map);
}

/// Checks the names of all channels. A missing name is already an error.
void check_names(const NamedTables& tables, const ImportMap& map) {
  record::RunInfo info;
  info.thermometers = make_channels(map, "");
  info.units = map.units;
  const auto table_with = [&](const record::NameTrouble& trouble) -> const TomlTable& {
    switch (trouble.of) {
      case record::NameTrouble::Of::thermometer: return tables.thermometers[trouble.index];
      case record::NameTrouble::Of::axis: return tables.axes[trouble.unit][trouble.index];
      case record::NameTrouble::Of::value: return tables.values[trouble.unit][trouble.index];
      case record::NameTrouble::Of::unit: break;
    }
    return tables.units[trouble.unit];
  };
  for (const auto& trouble : record::new_name_troubles(info))
    if (const TomlTable& table = table_with(trouble); table.has("name"))
      table.note_error("name", fmt::format("{}: {}", trouble.what, trouble.why));
}

void read_units(const TomlTable& root, ImportMap& map, NamedTables& tables) {
  if (root.is_list("gyro")) {
    for (const TomlTable& table : root.tables("gyro")) read_gyro(table, map, tables, true);
    if (map.units.empty()) root.note_error("gyro", "missing [[gyro]], expected at least one");
    return;
  }
  read_gyro(root.table("gyro"), map, tables, false);
  const TomlTable analysis = root.table("analysis");
  map.units.front().gradients = read_choice(analysis, "gradients", map);
  map.units.front().three_point = read_choice(analysis, "three_point", map);
}

}  // namespace

std::string describe(const ColumnName& column) {
  return column.name.empty() && column.number > 0 ? fmt::format("column {}", column.number)
                                                  : fmt::format("\"{}\"", plain(column.name));
}

const char* name(FileFormat format) { return keyword_for(kFormats, format); }

bool ImportMap::counts_increments(std::size_t unit) const { return axis_kind(units[unit]) == GyroKind::pulse_count; }

bool ImportMap::counts_increments() const {
  return std::ranges::any_of(units, [](const UnitInfo& unit) { return axis_kind(unit) == GyroKind::pulse_count; });
}

std::vector<ColumnName> ImportMap::columns() const {
  std::vector<ColumnName> all;
  for (const auto& thermometer : thermometer_columns) all.push_back(thermometer.column);
  all.insert(all.end(), axis_columns.begin(), axis_columns.end());
  for (const auto& value : value_columns) all.push_back(value.column);
  for (const auto& column : interval_columns)
    if (column) all.push_back(*column);
  return all;
}

std::vector<std::optional<ValidRange>> ImportMap::valid_ranges() const {
  std::vector<std::optional<ValidRange>> all;
  for (const auto& thermometer : thermometer_columns) all.push_back(thermometer.valid);
  all.insert(all.end(), axis_valid.begin(), axis_valid.end());
  all.resize(thermometer_columns.size() + axis_columns.size());
  for (const auto& value : value_columns) all.push_back(value.valid);
  all.resize(columns().size());
  return all;
}

namespace {

const char* column_key(const ColumnName& column) { return column.number > 0 ? "column_number" : "column"; }

/// Notes an error if the last thermometer has the column of an earlier one.
void note_repeated_column(const TomlTable& table, const ImportMap& map) {
  const auto& column = map.thermometer_columns.back().column;
  for (std::size_t i = 0; i + 1 < map.thermometer_columns.size(); ++i)
    if (is_same_column(map.thermometer_columns[i].column, column))
      return table.note_error(column_key(column), fmt::format("{} is also that of thermometer \"{}\"", describe(column),
                                                              map.thermometers[i]));
}

/// Notes an error for each axis with the column of a thermometer or of an earlier axis.
void note_repeated_axis_columns(const NamedTables& tables, const ImportMap& map) {
  std::size_t axis = 0;
  for (const auto& unit : tables.axes)
    for (const TomlTable& table : unit) {
      const auto& column = map.axis_columns[axis++];
      const auto note = [&](const std::string& owner) {
        table.note_error(column_key(column), fmt::format("{} is also that of {}", describe(column), owner));
      };
      for (std::size_t i = 0; i < map.thermometers.size(); ++i)
        if (is_same_column(map.thermometer_columns[i].column, column))
          note(fmt::format("thermometer \"{}\"", map.thermometers[i]));
      for (std::size_t i = 0; i + 1 < axis; ++i)
        if (is_same_column(map.axis_columns[i], column)) note("another axis");
    }
}

}  // namespace

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
    note_repeated_column(table, map);
  }
  read_units(*root, map, tables);
  note_repeated_axis_columns(tables, map);
  check_names(tables, map);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return map;
}

Result<ImportMap> load_import_map(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  return parse_import_map(*text, path);
}

namespace {

/// Returns the unit that a thermometer belongs to; empty if it belongs to all of them.
std::string owning_unit(const std::string& thermometer, const ImportMap& map) {
  if (map.units.size() == 1) return map.units.front().name;
  std::string owner;
  std::size_t owners = 0;
  for (const UnitInfo& unit : map.units)
    for (const auto* list : {&unit.gradients, &unit.three_point})
      if (std::ranges::find(*list, thermometer) != list->end() && (owners == 0 || owner != unit.name)) {
        owner = unit.name;
        ++owners;
      }
  return owners == 1 ? owner : "";
}

}  // namespace

std::vector<record::Channel> make_channels(const ImportMap& map, const std::string& instrument) {
  std::vector<record::Channel> channels;
  for (const auto& thermometer : map.thermometers)
    channels.push_back({.name = thermometer,
                        .instrument = instrument,
                        .offset = {},
                        .unit_under_test = owning_unit(thermometer, map)});
  return channels;
}

namespace {

std::string quoted(const std::vector<std::string>& names) {
  constexpr std::size_t kMaxListedNames = 60;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxListedNames); ++i)
    list += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", plain(names[i]));
  if (names.size() > kMaxListedNames) list += fmt::format(" and {} more", names.size() - kMaxListedNames);
  return list;
}

}  // namespace

std::string describe_missing_columns(const std::vector<std::string>& missing,
                                     const std::vector<std::string>& available) {
  return fmt::format("no column{} {}, expected one of: {}", missing.size() > 1 ? "s" : "", quoted(missing),
                     quoted(available));
}

}  // namespace gyrotherm::exchange
