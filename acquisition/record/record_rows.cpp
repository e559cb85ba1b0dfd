#include "acquisition/record/record_rows.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <initializer_list>

#include "acquisition/record/run_parts.hpp"
#include "acquisition/record/schema.hpp"

namespace gyrotherm {
namespace {

constexpr int kReaderPatienceMs = 0;  // a record being written stays so

template <class Kind>
Kind named(std::string_view text, std::initializer_list<Kind> kinds) {
  for (const Kind kind : kinds)
    if (text == name(kind)) return kind;
  return *kinds.begin();
}

/// Columns in the order of sample_columns().
void take(const Statement& row, StoredRow& into) {
  into.slot = row.integer(0);
  into.monotonic = Duration(row.integer(1));
  into.utc = row.null(2) ? std::nullopt : std::optional(Duration(row.integer(2)));
  into.progress.set_point = Celsius{row.real(3)};
  into.chamber_air_c = row.real(4);
  into.chamber_set_point_c = row.real(5);
  int column = 6;
  for (double& reading_c : into.thermometers_c) reading_c = row.real(column++);
  into.gyro = row.real(column);
  into.interval_s = row.real(column + 1) * 1e-9;
  if (row.null(column + 2)) return;
  into.progress.segment = static_cast<int>(row.integer(column + 2));
  into.progress.cycle = static_cast<int>(row.integer(column + 3));
  into.progress.phase = phase_named(row.text(column + 4));
  into.progress.in_segment = Duration(row.integer(column + 5));
  into.progress.soaked = Duration(row.integer(column + 6));
  if (row.columns() > column + 7) into.state = run_state_named(row.text(column + 7));
}

Result<std::string> columns_in(Database& database, const RunInfo& info) {
  return database.ask_integer("PRAGMA user_version", 0).map([&](std::int64_t version) {
    return sample_columns(info.thermometers, static_cast<int>(version));
  });
}

bool has_possible_times(const StoredRow& row) {
  const auto& progress = row.progress;
  return is_possible_time(row.monotonic) && (!row.utc || is_possible_time(*row.utc)) &&
         is_possible_time(progress.in_segment) && is_possible_time(progress.soaked);
}

StoredRow empty_row(const RunInfo& info) {
  StoredRow row;
  row.thermometers_c.resize(info.thermometers.size());
  return row;
}

}  // namespace

Phase phase_named(std::string_view text) {
  return named(text, {Phase::ramping, Phase::holding, Phase::waiting_for_soak, Phase::overdue, Phase::complete});
}

EventKind event_kind_named(std::string_view text) {
  return named(text, {EventKind::started, EventKind::resumed, EventKind::segment, EventKind::fault,
                      EventKind::recovered, EventKind::interlock, EventKind::note, EventKind::interrupted,
                      EventKind::finished, EventKind::state, EventKind::command});
}

RunState run_state_named(std::string_view text) {
  return named(text, {RunState::execute, RunState::suspended, RunState::held, RunState::aborting, RunState::aborted,
                      RunState::stopped, RunState::complete});
}

Result<Database> open_record(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    return failure(FaultKind::bad_file, path, "no such file, expected a gyrotherm record");
  if (!std::filesystem::is_regular_file(status))
    return failure(FaultKind::bad_file, path, "is no regular file, expected a gyrotherm record");
  auto database = Database::open(path, Access::read_only, kReaderPatienceMs);
  if (!database) return database;
  if (auto alone = check_no_journal(path, database->path()); !alone) return failure(alone.error());
  if (auto checked = check_schema(*database, path); !checked) return failure(checked.error());
  return database;
}

Result<void> each_sample(Database& database, const RunInfo& info, const std::function<void(const StoredRow&)>& use) {
  const auto columns = columns_in(database, info);
  if (!columns) return failure(columns.error());
  auto query = database.prepare(fmt::format("SELECT {} FROM sample ORDER BY slot", *columns));
  if (!query) return failure(query.error());
  StoredRow row = empty_row(info);
  for (;;) {
    const auto more = query->step();
    if (!more) return failure(more.error());
    if (!*more) return {};
    take(*query, row);
    if (!has_possible_times(row))
      return failure(FaultKind::bad_file, database.path(), fmt::format("second {} has impossible times", row.slot));
    use(row);
  }
}

Result<std::optional<StoredRow>> last_row(Database& database, const RunInfo& info) {
  const auto columns = columns_in(database, info);
  if (!columns) return failure(columns.error());
  auto query = database.prepare(fmt::format("SELECT {} FROM sample ORDER BY slot DESC LIMIT 1", *columns));
  if (!query) return failure(query.error());
  const auto more = query->step();
  if (!more) return failure(more.error());
  if (!*more) return std::nullopt;
  StoredRow row = empty_row(info);
  take(*query, row);
  return row;
}

Result<std::int64_t> last_slot(Database& database) {
  return database.ask_integer(
      "SELECT max(coalesce((SELECT max(slot) FROM sample), -1), coalesce((SELECT max(last) FROM gap), -1))", -1);
}

}  // namespace gyrotherm
