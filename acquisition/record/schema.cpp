#include "acquisition/record/schema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

#include "acquisition/record/run_info_rows.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm {
namespace {

constexpr int kApplicationId = 0x67797274;  // "gyrt"
constexpr int kUserVersion = 2;
constexpr std::size_t kLongestName = 64;

constexpr const char* kState = "state";  // not in version 1

struct Column {
  const char* name;
  const char* type;
};

constexpr std::array kBeforeThermometers{
    Column{"slot", "INTEGER PRIMARY KEY"}, Column{"monotonic_ns", "INTEGER NOT NULL"},
    Column{"utc_ns", "INTEGER"},           Column{"set_point_c", "REAL"},
    Column{"chamber_air_c", "REAL"},       Column{"chamber_set_point_c", "REAL"},
};

// NUMERIC: a foreign record keeps its rate in the place of the pulses.
constexpr std::array kAfterThermometers{
    Column{"pulses", "NUMERIC"},    Column{"interval_ns", "INTEGER"}, Column{"segment", "INTEGER"},
    Column{"cycle", "INTEGER"},     Column{"phase", "TEXT"},          Column{"in_segment_ns", "INTEGER"},
    Column{"soaked_ns", "INTEGER"}, Column{kState, "TEXT"},
};

constexpr const char* kOtherTables = R"(
CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE channel(position INTEGER PRIMARY KEY, name TEXT NOT NULL, instrument TEXT NOT NULL,
                     offset_k REAL NOT NULL);
CREATE TABLE calibration(position INTEGER PRIMARY KEY, polynomial TEXT NOT NULL, certificate TEXT NOT NULL,
                         due TEXT NOT NULL);
CREATE TABLE frames(id INTEGER PRIMARY KEY, seen INTEGER NOT NULL, lost INTEGER NOT NULL, bad INTEGER NOT NULL,
                    head TEXT NOT NULL);
CREATE TABLE segment(position INTEGER PRIMARY KEY, name TEXT NOT NULL, hold INTEGER NOT NULL, target_c REAL NOT NULL,
                     rate_c_per_min REAL NOT NULL, cycle INTEGER NOT NULL);
CREATE TABLE list(name TEXT NOT NULL, position INTEGER NOT NULL, value TEXT NOT NULL,
                  PRIMARY KEY(name, position)) WITHOUT ROWID;
CREATE TABLE fault(id INTEGER PRIMARY KEY, slot INTEGER NOT NULL, channel TEXT NOT NULL, kind TEXT NOT NULL,
                   "where" TEXT NOT NULL, what TEXT NOT NULL, chain INTEGER NOT NULL);
CREATE TABLE event(id INTEGER PRIMARY KEY, slot INTEGER NOT NULL, monotonic_ns INTEGER NOT NULL,
                   utc_ns INTEGER NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL, chain INTEGER NOT NULL);
CREATE TABLE gap(first INTEGER PRIMARY KEY, last INTEGER NOT NULL, cause TEXT NOT NULL, chain INTEGER NOT NULL);
)";

std::string quoted(const std::string& name) { return '"' + name + '"'; }

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool may_stand_in_a_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ' ' ||
         c == '.' || c == '-';
}

}  // namespace

Result<void> check_channel_names(const std::vector<Channel>& channels) {
  std::set<std::string> taken;
  for (const Column& column : kBeforeThermometers) taken.insert(column.name);
  for (const Column& column : kAfterThermometers) taken.insert(column.name);
  taken.insert("chain");
  for (const Channel& channel : channels) {
    const auto refuse = [&](const char* why) {
      return failure(FaultKind::bad_file, fmt::format("thermometer \"{}\"", channel.name), why);
    };
    if (channel.name.empty() || channel.name.size() > kLongestName) return refuse("a name has 1 to 64 characters");
    if (!std::all_of(channel.name.begin(), channel.name.end(), may_stand_in_a_name))
      return refuse("a name is made of letters, digits, blanks and _ . -");
    if (!taken.insert(lower(channel.name)).second) return refuse("the name is taken, expected one of its own");
  }
  return {};
}

Result<void> create_schema(Database& database, const std::vector<Channel>& channels) {
  std::string sample = "CREATE TABLE sample(";
  for (const Column& column : kBeforeThermometers) sample += fmt::format("{} {}, ", column.name, column.type);
  for (const Channel& channel : channels) sample += quoted(channel.name) + " REAL, ";
  for (const Column& column : kAfterThermometers) sample += fmt::format("{} {}, ", column.name, column.type);
  sample += "chain INTEGER NOT NULL);";
  return database.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};{}{}", kApplicationId,
                                      kUserVersion, kOtherTables, sample));
}

namespace {

std::string schema_named(std::int64_t version) { return fmt::format("gyrotherm-run/{}", version); }

tl::unexpected<Fault> another_schema(const std::string& path, const std::string& found) {
  return failure(FaultKind::bad_file, path, fmt::format("schema \"{}\", expected \"{}\"", found, kRunSchema));
}

/// The version that the file's header says, which no table needs to be read for.
Result<std::int64_t> header_version(Database& database, const std::string& path) {
  const auto id = database.ask_integer("PRAGMA application_id", 0);
  if (!id) return failure(id.error());
  if (*id != kApplicationId) return failure(FaultKind::bad_file, path, "not a gyrotherm record");
  const auto version = database.ask_integer("PRAGMA user_version", 0);
  if (!version) return failure(version.error());
  if (*version < 1 || *version > kUserVersion) return another_schema(path, schema_named(*version));
  return *version;
}

/// Whether all numbers that are seconds of the run could be some.
Result<void> check_slots(Database& database, const std::string& path) {
  const auto wrong = database.ask_integer(
      fmt::format(
          "SELECT coalesce((SELECT min(slot) FROM sample), 0) < 0 OR coalesce((SELECT max(slot) FROM sample), 0) > {0}"
          " OR EXISTS(SELECT 1 FROM gap WHERE first NOT BETWEEN 0 AND {0} OR last NOT BETWEEN first AND {0})"
          " OR EXISTS(SELECT 1 FROM event WHERE slot NOT BETWEEN -1 AND {0})"
          " OR EXISTS(SELECT 1 FROM fault WHERE slot NOT BETWEEN -1 AND {0})",
          kMostSlots),
      1);
  if (!wrong) return failure(wrong.error());
  if (*wrong == 0) return {};
  return failure(FaultKind::bad_file, path, fmt::format("a second of the run is not between 0 and {}", kMostSlots));
}

}  // namespace

Result<void> check_schema(Database& database, const std::string& path) {
  return header_version(database, path)
      .and_then([&](std::int64_t version) { return check_tables(database, path, static_cast<int>(version)); })
      .and_then([&] { return schema_version(database, path).map([](int) {}); })
      .and_then([&] { return check_slots(database, path); });
}

Result<int> schema_version(Database& database, const std::string& path) {
  const auto version = header_version(database, path);
  if (!version) return failure(version.error());
  const auto schema = meta(database, "schema");
  if (!schema) return failure(schema.error());
  if (*schema != schema_named(*version)) return another_schema(path, *schema);
  return static_cast<int>(*version);
}

Result<bool> has_table(Database& database, const char* name) {
  const auto count = database.ask_integer(
      fmt::format("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = '{}'", name), 0);
  if (!count) return failure(count.error());
  return *count > 0;
}

std::string sample_columns(const std::vector<Channel>& channels, int version) {
  std::string columns;
  for (const Column& column : kBeforeThermometers) columns += fmt::format("{}, ", column.name);
  for (const Channel& channel : channels) columns += quoted(channel.name) + ", ";
  for (const Column& column : kAfterThermometers)
    if (version >= kFirstChained || column.name != std::string_view(kState))
      columns += fmt::format("{}, ", column.name);
  columns.resize(columns.size() - 2);
  return columns;
}

}  // namespace gyrotherm
