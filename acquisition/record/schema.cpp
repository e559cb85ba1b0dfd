// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/schema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "acquisition/record/row.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm::record {

namespace {

constexpr int kApplicationId = 0x67797274;  // "gyrt"
constexpr int kUserVersion = 1;
constexpr std::size_t kLongestName = 64;
constexpr std::initializer_list<Measures> kAllMeasures = {
    Measures::temperature, Measures::rotation, Measures::interval, Measures::value,
    Measures::true_bias,   Measures::humidity, Measures::dew_point};

constexpr const char* kOtherTables = R"(
CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE unit(position INTEGER PRIMARY KEY, name TEXT NOT NULL, serial_number TEXT NOT NULL, model TEXT NOT NULL,
                  instrument TEXT NOT NULL, stream_text TEXT NOT NULL);
CREATE TABLE axis(unit INTEGER NOT NULL, position INTEGER NOT NULL, name TEXT NOT NULL, kind TEXT NOT NULL,
                  scale REAL NOT NULL, earth_rate_deg_per_h REAL, direction_x REAL, direction_y REAL, direction_z REAL,
                  latitude_deg REAL, azimuth_deg REAL, elevation_deg REAL, latitude_uncertainty_deg REAL,
                  azimuth_uncertainty_deg REAL, tilt_uncertainty_deg REAL, scale_factor_uncertainty_ppm REAL,
                  turn_on_repeatability_deg_per_h REAL, PRIMARY KEY(unit, position)) WITHOUT ROWID;
CREATE TABLE unit_value(unit INTEGER NOT NULL, position INTEGER NOT NULL, name TEXT NOT NULL,
                        unit_of_value TEXT NOT NULL, is_temperature INTEGER NOT NULL,
                        PRIMARY KEY(unit, position)) WITHOUT ROWID;
CREATE TABLE channel(position INTEGER PRIMARY KEY, name TEXT NOT NULL, measures TEXT NOT NULL, unit TEXT NOT NULL,
                     instrument TEXT NOT NULL, unit_under_test TEXT NOT NULL, offset_k REAL NOT NULL,
                     polynomial TEXT NOT NULL, certificate TEXT NOT NULL, due TEXT NOT NULL,
                     calibration_uncertainty_k REAL, distribution TEXT NOT NULL, drift_k_per_year REAL,
                     calibrated TEXT NOT NULL);
CREATE TABLE frames(id INTEGER PRIMARY KEY, seen INTEGER NOT NULL, lost INTEGER NOT NULL, bad INTEGER NOT NULL,
                    head TEXT NOT NULL);
CREATE TABLE segment(position INTEGER PRIMARY KEY, name TEXT NOT NULL, hold INTEGER NOT NULL, target_c REAL NOT NULL,
                     rate_c_per_min REAL NOT NULL, cycle INTEGER NOT NULL, prompt TEXT NOT NULL,
                     unit_off INTEGER NOT NULL, unit_turned INTEGER NOT NULL);
CREATE TABLE list(name TEXT NOT NULL, of TEXT NOT NULL, position INTEGER NOT NULL, value TEXT NOT NULL,
                  PRIMARY KEY(name, of, position)) WITHOUT ROWID;
CREATE TABLE fault(id INTEGER PRIMARY KEY, slot INTEGER NOT NULL, channel TEXT NOT NULL, kind TEXT NOT NULL,
                   "where" TEXT NOT NULL, what TEXT NOT NULL, chain INTEGER NOT NULL);
CREATE TABLE gap(first INTEGER PRIMARY KEY, last INTEGER NOT NULL, cause TEXT NOT NULL, chain INTEGER NOT NULL);
)";

constexpr const char* kTaken = "the name is already in use, expected a unique one";

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}
/// Returns whether a character is allowed in the name of a thermometer. More characters are allowed than in other
/// names, because an imported thermometer keeps its name.
bool is_thermometer_name_character(char c) { return is_name_character(c) || c == ' ' || c == '.'; }

/// Returns the reason why a name is malformed; nothing if it is not.
std::optional<std::string> name_trouble(std::string_view name, bool (*is_allowed)(char), const char* of) {
  if (name.empty() || name.size() > kLongestName) return "expected 1 to 64 characters";
  if (!std::ranges::all_of(name, is_allowed)) return fmt::format("expected only {}", of);
  return std::nullopt;
}

void find_malformed(const RunInfo& info, std::vector<NameTrouble>& troubles) {
  using enum NameTrouble::Of;
  const auto check = [&](NameTrouble::Of of, const char* kind, std::size_t unit, std::size_t index,
                         const std::string& name) {
    const auto why = of == thermometer
                         ? name_trouble(name, is_thermometer_name_character, "letters, digits, blanks and _ . -")
                         : name_trouble(name, is_name_character, "letters, digits and _ -");
    if (why) troubles.push_back({of, unit, index, fmt::format("{} \"{}\"", kind, name), *why});
  };
  for (std::size_t i = 0; i < info.thermometers.size(); ++i)
    check(thermometer, "thermometer", 0, i, info.thermometers[i].name);
  for (std::size_t i = 0; i < info.units.size(); ++i) {
    const UnitInfo& one = info.units[i];
    check(unit, "gyro", i, 0, one.name);
    for (std::size_t axis_index = 0; axis_index < one.axes.size(); ++axis_index)
      if (one.axes.size() > 1 || !one.axes[axis_index].name.empty())
        check(axis, "axis", i, axis_index, one.axes[axis_index].name);
    for (std::size_t value_index = 0; value_index < one.values.size(); ++value_index)
      check(value, "value", i, value_index, one.values[value_index].name);
  }
}

NameTrouble::Of named_object(Measures measures) {
  switch (measures) {
    case Measures::temperature: return NameTrouble::Of::thermometer;
    case Measures::rotation:
    case Measures::true_bias: return NameTrouble::Of::axis;
    case Measures::value: return NameTrouble::Of::value;
    case Measures::humidity:
    case Measures::dew_point:
    case Measures::interval: break;
  }
  return NameTrouble::Of::unit;
}

void find_duplicates(const RunInfo& info, std::vector<NameTrouble>& troubles) {
  std::set<std::string> taken{"chain"};
  for (const auto& column : columns_before_channels()) taken.insert(column.name);
  for (const auto& column : columns_after_channels()) taken.insert(column.name);
  auto columns = channel_columns(info);
  // Put thermometers last. A duplicate name is then reported for the thermometer and not for the other channel.
  std::ranges::stable_partition(columns, [](const auto& column) { return column.measures != Measures::temperature; });
  std::vector<NameTrouble> found;
  std::set<std::size_t> units;
  for (const auto& column : columns) {
    if (taken.insert(lower(column.name)).second) continue;
    const auto of = named_object(column.measures);
    const auto is_it = [&](const NameTrouble& one) {
      return one.of == of && one.unit == column.unit && one.index == column.index;
    };
    if (std::ranges::any_of(found, is_it)) continue;  // already found by another column
    if (of == NameTrouble::Of::unit) units.insert(column.unit);
    const char* kind = of == NameTrouble::Of::thermometer ? "thermometer" : "channel";
    found.push_back({of, column.unit, column.index, fmt::format("{} \"{}\"", kind, column.name), kTaken});
  }
  std::erase_if(found, [&](const NameTrouble& trouble) {
    const bool is_of_unit = trouble.of == NameTrouble::Of::axis || trouble.of == NameTrouble::Of::value;
    return is_of_unit && units.contains(trouble.unit);
  });
  troubles.insert(troubles.end(), found.begin(), found.end());
}

/// Returns the titles of those text table columns that every record has, in lower case and without units.
std::set<std::string> common_titles() {
  std::set<std::string> titles;
  const auto add = [&](const auto& column) {
    if (column.exported.title == nullptr) return;
    const std::string title = lower(column.exported.title);
    titles.insert(title.substr(0, title.rfind(" [")));
  };
  std::ranges::for_each(columns_before_channels(), add);
  std::ranges::for_each(columns_after_channels(), add);
  return titles;
}

}  // namespace

std::vector<NameTrouble> name_troubles(const RunInfo& info) {
  std::vector<NameTrouble> troubles;
  find_malformed(info, troubles);
  find_duplicates(info, troubles);
  return troubles;
}

std::set<std::string> reserved_channel_names() {
  auto names = common_titles();
  names.insert({"chain", "time", "time_s", "utc", "bias", "self", "at_rest", "chamber_humidity_percent",
                "chamber_dew_point_c", "chamber humidity", "chamber dew point"});
  for (const auto& column : columns_before_channels()) names.insert(column.name);
  for (const auto& column : columns_after_channels()) names.insert(column.name);
  return names;
}

std::vector<NameTrouble> new_name_troubles(const RunInfo& info) {
  auto troubles = name_troubles(info);
  auto taken = reserved_channel_names();
  for (const auto& column : channel_columns(info)) {
    if (!is_of_unit(column.measures)) continue;
    taken.insert(lower(calibrated_name(column)));
    if (column.measures != Measures::true_bias) continue;
    // Python adds a column with the bias: "u1.x.bias_deg_per_h".
    constexpr std::string_view kTrue = "true_";
    auto bias = lower(column.name);
    taken.insert(bias.erase(bias.rfind(kTrue), kTrue.size()));
  }
  const auto is_reported = [&](std::size_t i) {
    return std::ranges::any_of(troubles, [&](const NameTrouble& trouble) {
      return trouble.of == NameTrouble::Of::thermometer && trouble.index == i;
    });
  };
  for (std::size_t i = 0; i < info.thermometers.size(); ++i)
    if (const auto& name = info.thermometers[i].name; taken.contains(lower(name)) && !is_reported(i))
      troubles.push_back({NameTrouble::Of::thermometer, 0, i, fmt::format("thermometer \"{}\"", name), kTaken});
  return troubles;
}

namespace {

Result<void> first_fault(const std::vector<NameTrouble>& troubles) {
  return troubles.empty() ? Result<void>{} : failure(FaultKind::bad_file, troubles.front().what, troubles.front().why);
}

}  // namespace

Result<void> check_channel_names(const RunInfo& info) { return first_fault(name_troubles(info)); }

Result<void> check_new_channel_names(const RunInfo& info) { return first_fault(new_name_troubles(info)); }

namespace {

/// Formats a number as an SQL literal with a real type and the exact value.
std::string real(double number) {
  auto text = fmt::format("{}", number);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return number < 0 ? fmt::format("({})", text) : text;
}

/// Returns the SQL expression of a channel's calibrated temperature, as calibrated() computes it.
std::string temperature(const Channel& channel) {
  const auto reading = fmt::format("\"{}\"", channel.name);
  if (channel.polynomial.empty())
    return fmt::format("{} + (SELECT offset_k FROM channel WHERE channel.name = '{}' AND channel.measures = '{}')",
                       reading, channel.name, name(Measures::temperature));
  std::string sum = real(channel.polynomial.back());
  for (std::size_t i = channel.polynomial.size() - 1; i-- > 0;)
    sum = fmt::format("({} + {} * {})", real(channel.polynomial[i]), reading, sum);
  // Adding 0.0 * reading makes the result NULL if the reading is NULL.
  return channel.polynomial.size() == 1 ? fmt::format("{} + 0.0 * {}", sum, reading) : sum;
}

std::string interval_name(const RunInfo& info, std::size_t unit) {
  for (const ChannelColumn& column : channel_columns(info))
    if (column.measures == Measures::interval && column.unit == unit) return column.name;
  return "";
}

constexpr std::string_view kPulses = "pulses", kRateSuffix = "rate_deg_per_h", kNanoseconds = "ns", kSeconds = "s";

std::string rate(const ChannelColumn& column, const RunInfo& info) {
  const AxisInfo& axis = info.units[column.unit].axes[column.index];
  const auto number = fmt::format("{} * \"{}\"", real(axis.scale), column.name);
  const bool is_count = axis.kind == GyroKind::pulse_count;
  return fmt::format("{}{} AS \"{}\"", number,
                     is_count ? fmt::format(" / (\"{}\" / 1e9)", interval_name(info, column.unit)) : "",
                     calibrated_name(column));
}

std::string select_expression(const ChannelColumn& column, const RunInfo& info) {
  switch (column.measures) {
    case Measures::temperature:
      return fmt::format("{} AS \"{}\"", temperature(info.thermometers[column.index]), column.name);
    case Measures::rotation: return rate(column, info);
    case Measures::interval: return fmt::format("\"{}\" / 1e9 AS \"{}\"", column.name, calibrated_name(column));
    case Measures::value:
    case Measures::humidity:
    case Measures::dew_point:
    case Measures::true_bias: break;
  }
  return fmt::format("\"{}\"", column.name);
}

std::string utc_column(std::string_view nanoseconds) {
  return fmt::format("strftime('%Y-%m-%dT%H:%M:%fZ', {} / 1e9, 'unixepoch') AS utc", nanoseconds);
}

std::string sample_view(const RunInfo& info) {
  std::string sql =
      fmt::format("SELECT slot, monotonic_ns / 1e9 AS time_s, {}, set_point_c, chamber_air_c, chamber_set_point_c",
                  utc_column("utc_ns"));
  std::string truth;
  for (const ChannelColumn& column : channel_columns(info))
    (column.measures == Measures::true_bias ? truth : sql) += ", " + select_expression(column, info);
  return sql +
         ", (SELECT name FROM segment WHERE segment.position = sample.segment) AS segment, (SELECT value FROM list "
         "WHERE list.name = 'cycles' AND list.of = '' AND list.position = sample.cycle) AS cycle, phase, state" +
         truth + " FROM sample";
}

std::string event_view() {
  return fmt::format(
      "SELECT id, slot, monotonic_ns / 1e9 AS time_s, {}, kind, interlock, reaction, (SELECT name FROM segment WHERE "
      "segment.position = event.segment) AS segment, channel, text FROM event",
      utc_column("nullif(utc_ns, 0)"));
}

std::string channel_view() {
  return fmt::format(
      "SELECT position, CASE measures WHEN '{0}' THEN substr(name, 1, length(name) - {1}) || '{2}' WHEN '{3}' THEN "
      "substr(name, 1, length(name) - {4}) || '{5}' ELSE name END AS name, measures, CASE measures WHEN '{0}' THEN "
      "'°/h' WHEN '{3}' THEN 's' ELSE unit END AS unit, instrument, unit_under_test, certificate, due, "
      "calibration_uncertainty_k, distribution, drift_k_per_year, calibrated FROM channel",
      name(Measures::rotation), kPulses.size(), kRateSuffix, name(Measures::interval), kNanoseconds.size(), kSeconds);
}

}  // namespace

std::string calibrated_name(const ChannelColumn& column) {
  const auto with = [&](std::string_view ending, std::string_view by) {
    return column.name.substr(0, column.name.size() - ending.size()).append(by);
  };
  if (column.measures == Measures::rotation) return with(kPulses, kRateSuffix);
  if (column.measures == Measures::interval) return with(kNanoseconds, kSeconds);
  return column.name;
}

std::vector<View> record_views(const RunInfo& info) {
  std::vector<View> views{{"v1_channel", channel_view()},
                          {"v1_event", event_view()},
                          {"v1_gap", "SELECT first, last, last - first + 1 AS seconds, cause FROM gap"},
                          {"v1_sample", sample_view(info)}};
  for (View& view : views) view.sql = fmt::format("CREATE VIEW {} AS {}", view.name, view.sql);
  return views;
}

Result<void> create_schema(Database& database, const RunInfo& info) {
  std::string sample = "CREATE TABLE sample(";
  SampleColumns(info).each(
      [&](std::string_view name, std::string_view type) { sample += fmt::format("\"{}\" {}, ", name, type); });
  sample += "chain INTEGER NOT NULL);";
  std::string event = "CREATE TABLE event(id INTEGER PRIMARY KEY, ";
  for (const auto& column : event_columns()) event += fmt::format("{} {}, ", column.name, column.type);
  event += "chain INTEGER NOT NULL);";
  std::string views;
  for (const View& view : record_views(info)) views += view.sql + ";";
  return database.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};{}{}{}{}", kApplicationId,
                                      kUserVersion, kOtherTables, event, sample, views));
}

namespace {

tl::unexpected<Fault> another_schema(const std::string& path, const std::string& found) {
  return failure(FaultKind::bad_file, path, fmt::format("schema \"{}\", expected \"{}\"", found, kRunSchema));
}

/// Checks the file's header without reading any table.
Result<void> check_header(Database& database, const std::string& path) {
  const auto id = database.query_integer("PRAGMA application_id", 0);
  if (!id) return failure(id.error());
  if (*id != kApplicationId) return failure(FaultKind::bad_file, path, "not a gyrotherm record");
  const auto version = database.query_integer("PRAGMA user_version", 0);
  if (!version) return failure(version.error());
  if (*version != kUserVersion) return another_schema(path, fmt::format("gyrotherm-run/{}", *version));
  return {};
}

Result<void> check_schema_name(Database& database, const std::string& path) {
  const auto schema = meta(database, "schema");
  if (!schema) return failure(schema.error());
  return *schema == kRunSchema ? Result<void>{} : another_schema(path, *schema);
}

/// Checks that all slots in the tables are possible.
Result<void> check_slots(Database& database, const std::string& path) {
  const auto wrong = database.query_integer(
      fmt::format(
          "SELECT coalesce((SELECT min(slot) FROM sample), 0) < 0 OR coalesce((SELECT max(slot) FROM sample), 0) > {0}"
          " OR EXISTS(SELECT 1 FROM gap WHERE first NOT BETWEEN 0 AND {0} OR last NOT BETWEEN first AND {0})"
          " OR EXISTS(SELECT 1 FROM event WHERE slot NOT BETWEEN -1 AND {0})"
          " OR EXISTS(SELECT 1 FROM fault WHERE slot NOT BETWEEN -1 AND {0})",
          kMaxSlots),
      1);
  if (!wrong) return failure(wrong.error());
  if (*wrong == 0) return {};
  return failure(FaultKind::bad_file, path, fmt::format("a second of the run is not between 0 and {}", kMaxSlots));
}

}  // namespace

namespace {

/// The columns of a table, each with its type, whether it may be empty, its position in the key, and whether it is
/// computed.
using Columns = std::vector<std::string>;
using Tables = std::map<std::string, Columns, std::less<>>;

tl::unexpected<Fault> unexpected_content(const std::string& path, const std::string& what) {
  return failure(FaultKind::bad_file, path, fmt::format("{}, expected the tables of a record and nothing else", what));
}

Result<Columns> read_columns(Database& database, const std::string& table) {
  Columns columns;
  const auto read = database.each_row(fmt::format("PRAGMA table_xinfo(\"{}\")", table), [&](const Statement& row) {
    columns.push_back(
        fmt::format("{} {} {} {} {}", row.text(1), row.text(2), row.integer(3), row.integer(5), row.integer(6)));
  });
  return read.map([&] { return columns; });
}

/// Returns whether a view has the name of a view of a record. Does not check its text.
bool is_view_name(std::string_view name) {
  return std::ranges::any_of(record_views({}), [&](const View& view) { return view.name == name; });
}

/// Reads the columns of each table from the schema of the file. Executes nothing that the schema contains.
Result<Tables> read_tables(Database& database, const std::string& path) {
  std::vector<std::string> names;
  constexpr const char* kNames = "SELECT type, name, tbl_name, rootpage FROM sqlite_schema";
  const auto named = database.each_row(kNames, [&](const Statement& row) -> Result<void> {
    const std::string name(row.text(1));
    if (row.text(0) == "view" && is_view_name(name)) return {};
    names.push_back(name);
    if (row.text(0) == "table" && row.text(2) == name && row.integer(3) > 0) return {};
    return unexpected_content(path, fmt::format("it has a {} \"{}\"", row.text(0), name));
  });
  if (!named) return failure(named.error());
  Tables tables;
  for (const auto& name : names) {
    if (name.find('"') != std::string::npos) return unexpected_content(path, "it has a table with an invalid name");
    auto columns = read_columns(database, name);
    if (!columns) return failure(columns.error());
    tables.emplace(name, std::move(*columns));
  }
  return tables;
}

/// Returns the tables of a record without channels, as create_schema() creates them.
Result<Tables> expected_tables() {
  return Database::open(kInMemory, Access::read_write, 0).and_then([](Database memory) -> Result<Tables> {
    if (auto made = create_schema(memory, {}); !made) return failure(made.error());
    return read_tables(memory, kInMemory);
  });
}

/// The columns that depend on the record's channels: those before and those after columns_after_channels(). The table
/// `channel` must have been checked.
struct ChannelColumns {
  Columns before, after;
};

Result<ChannelColumns> read_channel_columns(Database& database) {
  ChannelColumns columns;
  const auto read =
      database.each_row("SELECT name, measures FROM channel ORDER BY position", [&](const Statement& row) {
        for (const auto measures : kAllMeasures)
          if (row.text(1) == name(measures))
            (measures == Measures::true_bias ? columns.after : columns.before)
                .push_back(fmt::format("{} {} 0 0 0", row.text(0), sql_type(measures)));
      });
  return read.map([&] { return columns; });
}

void add_channels(Columns& sample, const ChannelColumns& channels) {
  sample.insert(sample.begin() + std::ssize(columns_before_channels()), channels.before.begin(), channels.before.end());
  sample.insert(sample.end() - 1, channels.after.begin(), channels.after.end());  // before the column `chain`
}

Result<void> check_tables(Database& database, const std::string& path) {
  const auto found = read_tables(database, path);
  if (!found) return failure(found.error());
  auto expected = expected_tables();
  if (!expected) return failure(expected.error());
  const auto differs = [&](const std::string& table) {
    return unexpected_content(path, fmt::format("its table \"{}\" differs", table));
  };
  for (const auto& [name, columns] : *found)
    if (!expected->contains(name)) return differs(name);
  for (const auto& [name, columns] : *expected) {
    const auto table = found->find(name);
    if (table == found->end()) return unexpected_content(path, fmt::format("it has no table \"{}\"", name));
    if (name != "sample" && table->second != columns) return differs(name);
  }
  const auto channels = read_channel_columns(database);
  if (!channels) return failure(channels.error());
  add_channels((*expected)["sample"], *channels);
  return found->at("sample") == (*expected)["sample"] ? Result<void>{} : differs("sample");
}

/// Checks that the file has either exactly the views that its channels imply, or no views. The tables must have been
/// checked.
Result<void> check_views(Database& database, const std::string& path) {
  std::vector<View> found;
  constexpr const char* kViews = "SELECT name, sql FROM sqlite_schema WHERE type = 'view' ORDER BY name";
  const auto read = database.each_row(kViews, [&](const Statement& row) {
    found.push_back({std::string(row.text(0)), std::string(row.text(1))});
  });
  if (!read) return failure(read.error());
  if (found.empty()) return {};
  const auto info = read_run_info(database);
  if (!info) return failure(info.error());
  for (const View& view : record_views(*info))
    if (const auto same = std::ranges::find(found, view.name, &View::name); same == found.end() || *same != view)
      return unexpected_content(
          path, fmt::format("its view \"{}\" {}", view.name, same == found.end() ? "is missing" : "differs"));
  return {};
}

}  // namespace

Result<void> check_schema(Database& database, const std::string& path) {
  return check_header(database, path)
      .and_then([&] { return check_tables(database, path); })
      .and_then([&] { return check_schema_name(database, path); })
      .and_then([&] { return check_views(database, path); })
      .and_then([&] { return check_slots(database, path); });
}

}  // namespace gyrotherm::record
