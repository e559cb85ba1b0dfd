// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/import.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/schema.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::record {

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
  const std::string kind = table.choice("kind", {"rate", "increment"});
  axis.kind = kind == "increment" ? GyroKind::pulse_count : GyroKind::rate;
  axis.scale = read_scale(table, 0);
  if (table.has("earth_rate")) axis.earth_rate = DegreesPerHour{table.number("earth_rate")};
  if (axis.kind != kind_of(map)) table.mistake("kind", "a table's axes are all rates or all increments");
}

void read_value(const TomlTable& table, ImportMap& map, UnitInfo& unit) {
  const bool is_temperature = table.boolean("temperature", false);
  unit.values.push_back({.name = table.text("name"),
                         .unit = is_temperature ? "°C" : table.text("unit"),
                         .is_temperature = is_temperature});
  map.value_columns.push_back(read_scaled(table, map.header));
}

void read_gyro(const TomlTable& table, ImportMap& map, bool one_of_several) {
  UnitInfo unit;
  if (one_of_several) unit.name = table.text("name");
  unit.serial_number = table.text("serial_number", "");
  unit.model = table.text("model", "");
  map.units.push_back(std::move(unit));
  UnitInfo& made = map.units.back();
  if (!table.is_list("axis")) read_axis(table, map, made);
  for (const TomlTable& axis : table.tables("axis")) {
    read_axis(axis, map, made);
    made.axes.back().name = axis.text("name");
  }
  for (const TomlTable& value : table.tables("value")) read_value(value, map, made);
  if (!one_of_several) return;
  made.gradients = read_choice(table, "thermometers", map);
  made.three_point = read_choice(table, "three_point", map);
}

std::vector<Channel> channels_of(const ImportMap& map, const std::string& instrument) {
  std::vector<Channel> channels;
  for (const auto& thermometer : map.thermometers)
    channels.push_back({.name = thermometer, .instrument = instrument, .offset = {}});
  return channels;
}

void check_names(const TomlTable& root, const ImportMap& map) {
  RunInfo info;
  info.thermometers = channels_of(map, "");
  info.units = map.units;
  if (const auto good = check_channel_names(info); !good) root.mistake("thermometer", text(good.error()));
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
  for (const TomlTable& table : root->tables("thermometer")) {
    map.thermometers.push_back(table.text("name"));
    map.thermometer_columns.push_back(read_scaled(table, map.header));
  }
  if (root->is_list("gyro")) {
    for (const TomlTable& table : root->tables("gyro")) read_gyro(table, map, true);
    if (map.units.empty()) root->mistake("gyro", "missing [[gyro]], expected at least one");
  } else {
    read_gyro(root->table("gyro"), map, false);
    const TomlTable analysis = root->table("analysis");
    map.units.front().gradients = read_choice(analysis, "gradients", map);
    map.units.front().three_point = read_choice(analysis, "three_point", map);
  }
  check_names(*root, map);
  if (auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return map;
}

Result<ImportMap> load_import_map(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  return parse_import_map(*text, path);
}

namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr double kLongestTimeS = 3e8;  // ten years; far inside what 64 bits of nanoseconds hold
constexpr int kSilence = 10;           // times the median spacing

/// One pass over the file: lines are taken off `rest_`, the first fault ends it.
class Reader {
 public:
  Reader(std::string_view text, const ImportMap& map, const std::string& file) : rest_(text), map_(map), file_(file) {
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    rows_.thermometers_c.resize(map.thermometers.size());
    rows_.rotation.resize(map.axis_columns.size());
    rows_.values.resize(map.value_columns.size());
  }

  Result<ForeignRows> read() {
    if (map_.header)
      if (auto header = read_header(); !header) return failure(header.error());
    for (std::size_t i = 0; i < map_.skip; ++i)
      if (!next_line()) return failure(mistake(1, "the file ends among the lines to skip"));
    while (next_line()) {
      if (auto parted = part_line(); !parted) return failure(parted.error());
      if (width_ == 0)
        if (auto located = locate_columns(); !located) return failure(located.error());
      if (auto row = read_row(); !row) return failure(row.error());
    }
    if (rows_.time.empty()) return failure(mistake(1, "the file ends, expected at least one row"));
    return std::move(rows_);
  }

 private:
  /// Goes to the next line that is neither empty nor a comment; what is passed over may be of any length.
  bool next_line() {
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      line_ = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_number_;
      if (line_.ends_with('\r')) line_.remove_suffix(1);
      const bool comment = !map_.comment.empty() && line_.starts_with(map_.comment);
      if (!comment && !trimmed(line_).empty()) return true;
    }
    return false;
  }

  Result<void> part_line() {
    if (line_.size() > kLongestLine)
      return failure(
          mistake(kLongestLine + 1, fmt::format("more than {} bytes in a line, expected fewer", kLongestLine)));
    auto parted = cut(line_, map_.separator, fields_);
    if (!parted) parted.error().where = fmt::format("{}:{}:{}", file_, line_number_, parted.error().where);
    return parted;
  }

  Result<void> read_header() {
    if (!next_line()) return failure(mistake(1, "the file ends, expected a header"));
    if (auto parted = part_line(); !parted) return parted;
    return locate_columns();
  }

  Result<std::size_t> place_of(const ColumnName& column) const {
    if (!map_.header) {
      if (column.number <= width_) return column.number - 1;
      return failure(mistake(1, fmt::format("{} columns, expected at least {}", width_, column.number)));
    }
    const auto same = [&](const Field& field) { return trimmed(field.text) == trimmed(column.name); };
    const auto found = std::find_if(fields_.begin(), fields_.end(), same);
    if (found == fields_.end()) return failure(mistake(1, fmt::format("no column \"{}\" in the header", column.name)));
    if (const auto again = std::find_if(found + 1, fields_.end(), same); again != fields_.end())
      return failure(mistake(again->column, fmt::format("a second column \"{}\", expected one", column.name)));
    return static_cast<std::size_t>(found - fields_.begin());
  }

  /// From the header, or from the first row's width.
  Result<void> locate_columns() {
    width_ = fields_.size();
    if (map_.time)
      if (auto place = into(time_at_, place_of(*map_.time)); !place) return place;
    for (const auto& thermometer : map_.thermometer_columns)
      if (auto place = into(thermometers_at_.emplace_back(), place_of(thermometer.column)); !place) return place;
    for (const auto& axis : map_.axis_columns)
      if (auto place = into(axes_at_.emplace_back(), place_of(axis)); !place) return place;
    for (const auto& value : map_.value_columns)
      if (auto place = into(values_at_.emplace_back(), place_of(value.column)); !place) return place;
    return {};
  }

  Result<double> number_at(std::size_t index) const {
    const Field& field = fields_[index];
    if (const auto number = number_in(trimmed(field.text))) return *number;
    const char* hint = field.text.find(',') != std::string_view::npos ? " with a decimal point" : "";
    return failure(mistake(field.column, fmt::format("\"{}\", expected a number{}", field.text, hint)));
  }

  Result<void> read_time() {
    if (!time_at_) {
      rows_.time.push_back(map_.interval * static_cast<Duration::rep>(rows_.time.size()));
      return {};
    }
    const auto number = number_at(*time_at_);
    if (!number) return failure(number.error());
    if (!first_time_) first_time_ = *number;
    const double time_s = (*number - *first_time_) * to_seconds(map_.time_unit);
    const std::size_t column = fields_[*time_at_].column;
    if (std::abs(time_s) > kLongestTimeS) return failure(mistake(column, "more than ten years after the first row"));
    const Duration time = from_seconds(time_s);
    if (!rows_.time.empty() && time <= rows_.time.back())
      return failure(mistake(column, "the time does not increase, expected one after the row before"));
    rows_.time.push_back(time);
    return {};
  }

  Result<void> read_row() {
    if (fields_.size() != width_)
      return failure(mistake(1, fmt::format("{} fields, expected {}", fields_.size(), width_)));
    if (auto time = read_time(); !time) return time;
    if (auto read = read_scaled(thermometers_at_, map_.thermometer_columns, rows_.thermometers_c); !read) return read;
    for (std::size_t i = 0; i < axes_at_.size(); ++i) {
      const auto number = number_at(axes_at_[i]);
      if (!number) return failure(number.error());
      rows_.rotation[i].push_back(*number);
    }
    return read_scaled(values_at_, map_.value_columns, rows_.values);
  }

  Result<void> read_scaled(const std::vector<std::size_t>& places, const std::vector<ImportMap::ScaledColumn>& columns,
                           std::vector<std::vector<double>>& into) const {
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto number = number_at(places[i]);
      if (!number) return failure(number.error());
      into[i].push_back(*number * columns[i].scale + columns[i].offset);
    }
    return {};
  }

  Fault mistake(std::size_t column, std::string what) const {
    return {FaultKind::bad_file, fmt::format("{}:{}:{}", file_, line_number_, column), std::move(what)};
  }

  std::string_view rest_;
  const ImportMap& map_;
  const std::string& file_;
  std::string_view line_;
  std::size_t line_number_{};
  std::vector<Field> fields_;
  std::size_t width_{};  ///< fields of the header, or of the first row
  std::optional<std::size_t> time_at_;
  std::vector<std::size_t> thermometers_at_, axes_at_, values_at_;
  std::optional<double> first_time_;
  ForeignRows rows_;
};

std::vector<Duration> spacings(const std::vector<Duration>& time) {
  std::vector<Duration> spacing;
  for (std::size_t i = 1; i < time.size(); ++i) spacing.push_back(time[i] - time[i - 1]);
  return spacing;
}

Duration median(std::vector<Duration> values) {
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Duration> intervals(const std::vector<Duration>& time, const ImportMap& map) {
  if (!map.time) return std::vector<Duration>(time.size(), map.interval);
  std::vector<Duration> interval = spacings(time);
  const Duration usual = median(interval);
  interval.insert(interval.begin(), usual);
  if (kind_of(map) == GyroKind::rate) std::fill(interval.begin(), interval.end(), usual);
  return interval;
}

}  // namespace

Result<ForeignRows> parse_foreign_rows(std::string_view text, const ImportMap& map, const std::string& file) {
  auto rows = Reader(text, map, file).read();
  if (rows) rows->interval = intervals(rows->time, map);
  return rows;
}

Silences find_silences(const std::vector<Duration>& time) {
  const std::vector<Duration> spacing = spacings(time);
  Silences silences{.median = median(spacing)};
  for (std::size_t i = 0; i < spacing.size(); ++i) {
    if (spacing[i] <= kSilence * silences.median) continue;
    if (silences.count == 0) {
      silences.first_after = i;
      silences.first = spacing[i];
    }
    ++silences.count;
    silences.total += spacing[i];
  }
  return silences;
}

namespace {

/// FNV-1a, 64 bits (Fowler, Noll, Vo; RFC 9923): the id of an import depends on its input alone.
std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  return hash;
}

RunInfo describe(const ImportMap& map, std::string_view table, const std::string& table_path,
                 const std::string& program_version) {
  const auto file = plain(std::filesystem::path(table_path).filename().string());
  RunInfo info;
  info.id = fmt::format("{:016x}{:016x}", fnv1a(table), fnv1a(map.text));
  info.program_version = program_version;
  info.profile_name = file;
  info.rig_name = map.name;
  info.rig_text = map.text;
  info.imported = true;
  info.thermometers = channels_of(map, "imported from " + file);
  info.units = map.units;
  return info;
}

Result<void> insert_silences(RunFile& run, const ForeignRows& rows, const Silences& silences) {
  if (silences.count == 0) return {};
  const Event event{
      {rows.time[silences.first_after], {}},
      EventKind::note,
      fmt::format("{} gaps longer than 10 times the median spacing of {:g} s, {:g} s in all; the first, of "
                  "{:g} s, after row {}",
                  silences.count, to_seconds(silences.median), to_seconds(silences.total), to_seconds(silences.first),
                  silences.first_after)};
  return run.insert_event(static_cast<std::int64_t>(silences.first_after), event);
}

void take_row(const ForeignRows& rows, std::size_t i, SampleRow& row) {
  for (std::size_t channel = 0; channel < row.thermometers_c.size(); ++channel)
    row.thermometers_c[channel] = rows.thermometers_c[channel][i];
  auto rotation = rows.rotation.begin();
  auto values = rows.values.begin();
  for (UnitRow& unit : row.units) {
    unit.interval = rows.interval[i];
    for (double& number : unit.rotation) number = (*rotation++)[i];
    for (double& number : unit.values) number = (*values++)[i];
  }
}

Result<void> insert_rows(RunFile& run, const ForeignRows& rows, const Silences& silences) {
  SampleRow row = empty_row(run.info());
  for (std::size_t i = 0; i < rows.time.size(); ++i) {
    row.slot = static_cast<std::int64_t>(i);
    row.monotonic = rows.time[i];
    take_row(rows, i, row);
    if (auto inserted = run.insert(row); !inserted) return inserted;
    if (i != silences.first_after) continue;
    if (auto inserted = insert_silences(run, rows, silences); !inserted) return inserted;
  }
  return {};
}

Result<void> write(const std::string& path, const RunInfo& info, const ForeignRows& rows, const Silences& silences) {
  auto run = RunFile::create(path, info);
  if (!run) return failure(run.error());
  auto written = run->begin()
                     .and_then([&] { return insert_rows(*run, rows, silences); })
                     .and_then([&] { return run->replace_frames({}); })
                     .and_then([&] { return run->commit(); })
                     .and_then([&] { return run->finish(); });
  run = failure(FaultKind::storage, path, "closed");
  if (written) written = write_manifest(path, 1);
  if (!written) ::unlink(path.c_str());
  return written;
}

}  // namespace

Result<ImportSummary> import_record(const std::string& table_path, const std::string& map_path,
                                    const std::string& record_path, const std::string& program_version) {
  const auto map = load_import_map(map_path);
  if (!map) return failure(map.error());
  const auto table = read_text_file(table_path, kLargestTable);
  if (!table) return failure(table.error());
  const auto rows = parse_foreign_rows(*table, *map, table_path);
  if (!rows) return failure(rows.error());
  const Silences silences = find_silences(rows->time);
  const RunInfo info = describe(*map, *table, table_path, program_version);
  if (auto written = write(record_path, info, *rows, silences); !written) return failure(written.error());
  return ImportSummary{rows->time.size(), rows->time.back(), silences.count};
}

}  // namespace gyrotherm::record
