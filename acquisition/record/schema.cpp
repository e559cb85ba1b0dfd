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

constexpr const char* kOtherTables = R"(
CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE channel(position INTEGER PRIMARY KEY, name TEXT NOT NULL, unit TEXT NOT NULL, instrument TEXT NOT NULL,
                     unit_under_test TEXT NOT NULL, offset_k REAL NOT NULL, polynomial TEXT NOT NULL,
                     certificate TEXT NOT NULL, due TEXT NOT NULL, calibration_uncertainty_k REAL,
                     distribution TEXT NOT NULL, drift_k_per_year REAL, calibrated TEXT NOT NULL);
CREATE TABLE frames(id INTEGER PRIMARY KEY, seen INTEGER NOT NULL, lost INTEGER NOT NULL, bad INTEGER NOT NULL,
                    head TEXT NOT NULL);
CREATE TABLE segment(position INTEGER PRIMARY KEY, name TEXT NOT NULL, hold INTEGER NOT NULL, target_c REAL NOT NULL,
                     rate_c_per_min REAL NOT NULL, cycle INTEGER NOT NULL, prompt TEXT NOT NULL,
                     unit_off INTEGER NOT NULL, unit_turned INTEGER NOT NULL);
CREATE TABLE list(name TEXT NOT NULL, position INTEGER NOT NULL, value TEXT NOT NULL,
                  PRIMARY KEY(name, position)) WITHOUT ROWID;
CREATE TABLE fault(id INTEGER PRIMARY KEY, slot INTEGER NOT NULL, channel TEXT NOT NULL, kind TEXT NOT NULL,
                   "where" TEXT NOT NULL, what TEXT NOT NULL, chain INTEGER NOT NULL);
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

bool is_own_column(std::string_view name) {
  const auto has = [&](std::span<const Column<SampleRow>> columns) {
    return std::ranges::any_of(columns, [&](const auto& column) { return column.name == name; });
  };
  return has(columns_before_thermometers()) || has(columns_after_thermometers());
}

Result<void> check_channel_names(const std::vector<Channel>& channels) {
  std::set<std::string> taken;
  for (const auto& column : columns_before_thermometers()) taken.insert(column.name);
  for (const auto& column : columns_after_thermometers()) taken.insert(column.name);
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
  for (const auto& column : columns_before_thermometers()) sample += fmt::format("{} {}, ", column.name, column.type);
  for (const Channel& channel : channels) sample += quoted(channel.name) + " REAL, ";
  for (const auto& column : columns_after_thermometers()) sample += fmt::format("{} {}, ", column.name, column.type);
  sample += "chain INTEGER NOT NULL);";
  std::string event = "CREATE TABLE event(id INTEGER PRIMARY KEY, ";
  for (const auto& column : columns_of_events()) event += fmt::format("{} {}, ", column.name, column.type);
  event += "chain INTEGER NOT NULL);";
  return database.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};{}{}{}", kApplicationId,
                                      kUserVersion, kOtherTables, event, sample));
}

namespace {

tl::unexpected<Fault> another_schema(const std::string& path, const std::string& found) {
  return failure(FaultKind::bad_file, path, fmt::format("schema \"{}\", expected \"{}\"", found, kRunSchema));
}

/// Looks at the file's header alone, which no table needs to be read for.
Result<void> check_header(Database& database, const std::string& path) {
  const auto id = database.ask_integer("PRAGMA application_id", 0);
  if (!id) return failure(id.error());
  if (*id != kApplicationId) return failure(FaultKind::bad_file, path, "not a gyrotherm record");
  const auto version = database.ask_integer("PRAGMA user_version", 0);
  if (!version) return failure(version.error());
  if (*version != kUserVersion) return another_schema(path, fmt::format("gyrotherm-run/{}", *version));
  return {};
}

Result<void> check_schema_name(Database& database, const std::string& path) {
  const auto schema = meta(database, "schema");
  if (!schema) return failure(schema.error());
  return *schema == kRunSchema ? Result<void>{} : another_schema(path, *schema);
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

std::string sample_columns(const std::vector<Channel>& channels) {
  std::string columns = names_of(columns_before_thermometers());
  for (const Channel& channel : channels) columns += ", " + quoted(channel.name);
  return columns + ", " + names_of(columns_after_thermometers());
}

namespace {

/// A table's columns, each with its type, whether it may be empty, its place in the key, and whether it is computed.
using Columns = std::vector<std::string>;
using Tables = std::map<std::string, Columns, std::less<>>;

tl::unexpected<Fault> other_than_a_record(const std::string& path, const std::string& what) {
  return failure(FaultKind::bad_file, path, fmt::format("{}, expected the tables of a record and nothing else", what));
}

Result<Columns> columns_of(Database& database, const std::string& table) {
  Columns columns;
  const auto read = database.each_row(fmt::format("PRAGMA table_xinfo(\"{}\")", table), [&](const Statement& row) {
    columns.push_back(
        fmt::format("{} {} {} {} {}", row.text(1), row.text(2), row.integer(3), row.integer(5), row.integer(6)));
  });
  return read.map([&] { return columns; });
}

/// The tables of a file, by what its schema says; nothing of it is run.
Result<Tables> tables_of(Database& database, const std::string& path) {
  std::vector<std::string> names;
  constexpr const char* kNames = "SELECT type, name, tbl_name, rootpage FROM sqlite_schema";
  const auto named = database.each_row(kNames, [&](const Statement& row) -> Result<void> {
    const auto& name = names.emplace_back(row.text(1));
    if (row.text(0) == "table" && row.text(2) == name && row.integer(3) > 0) return {};
    return other_than_a_record(path, fmt::format("it has a {} \"{}\"", row.text(0), name));
  });
  if (!named) return failure(named.error());
  Tables tables;
  for (const auto& name : names) {
    if (name.find('"') != std::string::npos) return other_than_a_record(path, "it has a table of another name");
    auto columns = columns_of(database, name);
    if (!columns) return failure(columns.error());
    tables.emplace(name, std::move(*columns));
  }
  return tables;
}

/// What create_schema() makes, without its thermometers.
Result<Tables> expected_tables() {
  return Database::open(kInMemory, Access::read_write, 0).and_then([](Database memory) -> Result<Tables> {
    if (auto made = create_schema(memory, {}); !made) return failure(made.error());
    return tables_of(memory, kInMemory);
  });
}

/// The names of the thermometers among the channels, of a table that has been found to be one.
Result<std::vector<std::string>> channel_names(Database& database) {
  std::vector<std::string> names;
  const auto read = database.each_row("SELECT name FROM channel ORDER BY position", [&](const Statement& row) {
    if (!is_own_column(row.text(0))) names.emplace_back(row.text(0));
  });
  return read.map([&] { return names; });
}

/// The samples have a column for each thermometer, behind the chamber's.
void add_thermometers(Columns& sample, const std::vector<std::string>& names) {
  auto at = sample.begin() + std::ssize(columns_before_thermometers());
  for (const auto& name : names) at = sample.insert(at, name + " REAL 0 0 0") + 1;
}

Result<void> check_tables(Database& database, const std::string& path) {
  const auto found = tables_of(database, path);
  if (!found) return failure(found.error());
  auto expected = expected_tables();
  if (!expected) return failure(expected.error());
  const auto differs = [&](const std::string& table) {
    return other_than_a_record(path, fmt::format("its table \"{}\" is another one", table));
  };
  for (const auto& [name, columns] : *found)
    if (!expected->contains(name)) return differs(name);
  for (const auto& [name, columns] : *expected) {
    const auto table = found->find(name);
    if (table == found->end()) return other_than_a_record(path, fmt::format("it has no table \"{}\"", name));
    if (name != "sample" && table->second != columns) return differs(name);
  }
  const auto names = channel_names(database);
  if (!names) return failure(names.error());
  add_thermometers((*expected)["sample"], *names);
  return found->at("sample") == (*expected)["sample"] ? Result<void>{} : differs("sample");
}

}  // namespace

Result<void> check_schema(Database& database, const std::string& path) {
  return check_header(database, path)
      .and_then([&] { return check_tables(database, path); })
      .and_then([&] { return check_schema_name(database, path); })
      .and_then([&] { return check_slots(database, path); });
}

}  // namespace gyrotherm::record
