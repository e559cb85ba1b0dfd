// SPDX-License-Identifier: Apache-2.0
/// gyrotherm-record-bench FOLDER compares the costs of a record with those of a plain SQLite table, for the rows of the
/// whole qualification. Plain SQLite writes the rows in one transaction. The record also chains every row and verifies
/// the chain when it is read.
#include <fmt/format.h>
#include <sqlite3.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "acquisition/record/record.hpp"
#include "acquisition/record/store.hpp"
#include "bench/measurement.hpp"

namespace gyrotherm::bench {
namespace {

/// Seconds of the qualification.
constexpr std::int64_t kSlots = 221'600;

/// Ends the program at the first SQLite error, because nothing can be compared after it.
void expect(bool done, sqlite3* database) {
  if (done) return;
  fmt::print(stderr, "plain SQLite: {}\n", sqlite3_errmsg(database));
  std::exit(1);
}

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using Query = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

Database open_plain_database(const std::string& path) {
  sqlite3* opened = nullptr;
  const bool done = sqlite3_open(path.c_str(), &opened) == SQLITE_OK;
  expect(done, opened);
  return {opened, &sqlite3_close};
}

Query prepare(const Database& database, const std::string& sql) {
  sqlite3_stmt* prepared = nullptr;
  expect(sqlite3_prepare_v2(database.get(), sql.c_str(), -1, &prepared, nullptr) == SQLITE_OK, database.get());
  return {prepared, &sqlite3_finalize};
}

void execute(const Database& database, const std::string& sql) {
  expect(sqlite3_exec(database.get(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK, database.get());
}

/// Returns the processor seconds of reading every value of every row.
double measure_reading(const Database& database) {
  const auto rows = prepare(database, "SELECT * FROM sample");
  const double began_s = thread_seconds();
  while (sqlite3_step(rows.get()) == SQLITE_ROW)
    for (int column = 0; column < sqlite3_column_count(rows.get()); ++column)
      static_cast<void>(sqlite3_column_value(rows.get(), column));
  return thread_seconds() - began_s;
}

/// Returns the processor seconds of reading every row and writing it again, one insertion each, in one transaction.
double measure_copying(const Database& database, const std::string& into) {
  execute(database, fmt::format("ATTACH '{}' AS peer; PRAGMA peer.journal_mode = WAL; "
                                "CREATE TABLE peer.sample AS SELECT * FROM main.sample WHERE 0; BEGIN",
                                into));
  const auto rows = prepare(database, "SELECT * FROM main.sample");
  std::string places = "?";
  for (int column = 1; column < sqlite3_column_count(rows.get()); ++column) places += ", ?";
  const auto insertion = prepare(database, fmt::format("INSERT INTO peer.sample VALUES ({})", places));
  const double began_s = thread_seconds();
  while (sqlite3_step(rows.get()) == SQLITE_ROW) {
    for (int column = 0; column < sqlite3_column_count(rows.get()); ++column)
      sqlite3_bind_value(insertion.get(), column + 1, sqlite3_column_value(rows.get(), column));
    expect(sqlite3_step(insertion.get()) == SQLITE_DONE, database.get());
    sqlite3_reset(insertion.get());
  }
  execute(database, "COMMIT");
  return thread_seconds() - began_s;
}

int run(const std::filesystem::path& folder) {
  const auto path = (folder / "run.db").string();
  std::filesystem::remove(path);
  record::RunInfo info;
  info.id = std::string(32, '0');
  info.program_version = "bench";
  info.started_utc = kVirtualEpoch;
  info.units = {{.axes = {{.scale = 0.1, .earth_rate = DegreesPerHour{10.636}}}}};
  for (int i = 0; i < 9; ++i) info.thermometers.push_back({fmt::format("T{}", i), "", {}});
  auto store = record::Store::create(path, info);
  if (!store) return fmt::print(stderr, "{}\n", text(store.error())), 1;
  Sample sample;
  const Instant at{{}, kVirtualEpoch};
  sample.at = at;
  sample.chamber = {ChamberState{Celsius{20}, Celsius{21}}, at};
  sample.thermometers.resize(9, {Celsius{20.123456}, at});
  sample.units = {{.count = {GyroCount{{-1000}, std::chrono::nanoseconds(1'000'000'001)}, at}}};
  const double began_s = thread_seconds();
  for (sample.slot = 0; sample.slot < kSlots; ++sample.slot)
    if (const auto appended = (*store)->append(sample, {}); !appended)
      return fmt::print(stderr, "{}\n", text(appended.error())), 1;
  const double appended_s = thread_seconds() - began_s;
  if (const auto finished = (*store)->finish(); !finished) return fmt::print(stderr, "{}\n", text(finished.error())), 1;
  store->reset();

  const double reading_s = thread_seconds();
  const auto record = record::read_record(path);
  const double read_s = thread_seconds() - reading_s;
  const bool whole = record && record->slot.size() == static_cast<std::size_t>(kSlots);

  const auto peer = (folder / "peer.db").string();
  std::filesystem::remove(peer);
  const auto database = open_plain_database(path);
  const double plain_read_s = measure_reading(database);
  const double plain_write_s = measure_copying(database, peer) - plain_read_s;
  print_figure("append, µs per row", appended_s * 1e6 / kSlots, at_most(5), whole);
  print_figure("read, s", read_s, at_most(1), whole);
  print_figure("append, relative to plain SQLite", appended_s / plain_write_s, at_most(4), whole);
  print_figure("read, relative to plain SQLite", read_s / plain_read_s, at_most(4), whole);
  return 0;
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) {
  if (argc == 2) return gyrotherm::bench::run(argv[1]);
  std::fputs("usage: gyrotherm-record-bench FOLDER\n", stderr);
  return 2;
}
