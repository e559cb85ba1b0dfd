#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "acquisition/record/schema.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm {
namespace {

/// A table's columns, each with its type, whether it may be empty, its place in the key, and whether it is computed.
using Columns = std::vector<std::string>;
using Tables = std::map<std::string, Columns, std::less<>>;

tl::unexpected<Fault> other_than_a_record(const std::string& path, const std::string& what) {
  return failure(FaultKind::bad_file, path, fmt::format("{}, expected the tables of a record and nothing else", what));
}

Result<Columns> columns_of(Database& database, const std::string& table) {
  auto query = database.prepare(fmt::format("PRAGMA table_xinfo(\"{}\")", table));
  if (!query) return failure(query.error());
  Columns columns;
  for (;;) {
    const auto more = query->step();
    if (!more) return failure(more.error());
    if (!*more) return columns;
    columns.push_back(fmt::format("{} {} {} {} {}", query->text(1), query->text(2), query->integer(3),
                                  query->integer(5), query->integer(6)));
  }
}

/// The tables of a file, by what its schema says; nothing of it is run.
Result<Tables> tables_of(Database& database, const std::string& path) {
  std::vector<std::string> names;
  {
    auto query = database.prepare("SELECT type, name, tbl_name, rootpage FROM sqlite_schema");
    if (!query) return failure(query.error());
    for (;;) {
      const auto more = query->step();
      if (!more) return failure(more.error());
      if (!*more) break;
      const std::string name(query->text(1));
      if (query->text(0) != "table" || query->text(2) != name || query->integer(3) <= 0)
        return other_than_a_record(path, fmt::format("it has a {} \"{}\"", query->text(0), name));
      names.push_back(name);
    }
  }
  Tables tables;
  for (const auto& name : names) {
    if (name.find('"') != std::string::npos) return other_than_a_record(path, "it has a table of another name");
    auto columns = columns_of(database, name);
    if (!columns) return failure(columns.error());
    tables.emplace(name, std::move(*columns));
  }
  return tables;
}

void remove_column(Columns& columns, std::string_view name) {
  std::erase_if(columns, [&](const std::string& column) { return column.starts_with(std::string(name) + " "); });
}

/// What create_schema() makes, without its thermometers, or what it made when records had this version.
Result<Tables> expected_tables(int version) {
  return Database::open(kInMemory, Access::read_write, 0).and_then([&](Database memory) -> Result<Tables> {
    if (auto made = create_schema(memory, {}); !made) return failure(made.error());
    auto tables = tables_of(memory, kInMemory);
    if (!tables || version >= kFirstChained) return tables;
    for (auto& [name, columns] : *tables) remove_column(columns, "chain");
    remove_column((*tables)["sample"], "state");
    remove_column((*tables)["frames"], "head");
    remove_column((*tables)["fault"], "id");
    return tables;
  });
}

/// The names of the thermometers, of a table that has been found to be one.
Result<std::vector<std::string>> channel_names(Database& database) {
  auto query = database.prepare("SELECT name FROM channel ORDER BY position");
  if (!query) return failure(query.error());
  std::vector<std::string> names;
  for (;;) {
    const auto more = query->step();
    if (!more) return failure(more.error());
    if (!*more) return names;
    names.emplace_back(query->text(0));
  }
}

/// The samples have a column for each thermometer, behind the chamber's.
void add_thermometers(Columns& sample, const std::vector<std::string>& names) {
  const auto pulses =
      std::find_if(sample.begin(), sample.end(), [](const auto& column) { return column.starts_with("pulses "); });
  std::vector<std::string> columns;
  for (const auto& name : names) columns.push_back(name + " REAL 0 0 0");
  sample.insert(pulses, columns.begin(), columns.end());
}

bool older_records_lack(const std::string& table) { return table == "calibration" || table == "frames"; }

}  // namespace

Result<void> check_tables(Database& database, const std::string& path, int version) {
  const auto found = tables_of(database, path);
  if (!found) return failure(found.error());
  auto expected = expected_tables(version);
  if (!expected) return failure(expected.error());
  const auto differs = [&](const std::string& table) {
    return other_than_a_record(path, fmt::format("its table \"{}\" is another one", table));
  };
  for (const auto& [name, columns] : *found)
    if (!expected->contains(name)) return differs(name);
  for (const auto& [name, columns] : *expected) {
    const auto table = found->find(name);
    if (table == found->end() && version < kFirstChained && older_records_lack(name)) continue;
    if (table == found->end()) return other_than_a_record(path, fmt::format("it has no table \"{}\"", name));
    if (name != "sample" && table->second != columns) return differs(name);
  }
  const auto names = channel_names(database);
  if (!names) return failure(names.error());
  add_thermometers((*expected)["sample"], *names);
  return found->at("sample") == (*expected)["sample"] ? Result<void>{} : differs("sample");
}

}  // namespace gyrotherm
