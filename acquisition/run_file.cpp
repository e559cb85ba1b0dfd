#include "acquisition/run_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "acquisition/run_info_rows.hpp"
#include "acquisition/schema.hpp"
#include "acquisition/store.hpp"

namespace gyrotherm {
namespace {

constexpr int kPatienceMs = 500;  // a second program is told within a second

struct Setting {
  const char* pragma;
  const char* value;
  const char* read_back;
};

/// Exclusive before WAL, so that the log's index lives in memory and no -shm file exists; FULL, so that a commit is on
/// the disk when it returns. The log is folded in by fold_log(), at 200 pages: SQLite's own way would hide its failure.
constexpr std::array kDurable{
    Setting{"journal_mode", "WAL", "wal"},
    Setting{"synchronous", "FULL", "2"},
    Setting{"wal_autocheckpoint", "0", "0"},
};
constexpr int kLongLogPages = 200;
constexpr Setting kExclusive{"locking_mode", "EXCLUSIVE", "exclusive"};
constexpr Setting kOneFile{"journal_mode", "DELETE", "delete"};

Result<void> apply(Database& database, const Setting& setting, const std::string& path) {
  if (const auto set = database.ask(fmt::format("PRAGMA {} = {}", setting.pragma, setting.value)); !set)
    return failure(set.error());
  const auto now = database.ask(fmt::format("PRAGMA {}", setting.pragma));
  if (!now) return failure(now.error());
  if (*now == setting.read_back) return {};
  return failure(FaultKind::storage, path,
                 fmt::format("SQLite keeps {} at \"{}\", expected \"{}\"", setting.pragma, *now, setting.read_back));
}

Result<void> make_durable(Database& database, const std::string& path) {
  for (const Setting& setting : kDurable)
    if (auto applied = apply(database, setting, path); !applied) return applied;
  return {};
}

/// An empty file that did not exist before; SQLite takes it for an empty database.
Result<void> make_new_file(const std::string& path) {
  const int file = ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0644);
  if (file < 0 && errno == EEXIST)
    return failure(FaultKind::storage, path, "exists already, and a record is never overwritten");
  if (file < 0) return failure(FaultKind::storage, path, std::strerror(errno));
  ::close(file);
  return {};
}

bool in_memory(const std::string& path) { return path == kInMemory; }

Result<void> fill_new_file(Database& database, const std::string& path, const RunInfo& info,
                           const std::optional<Continuation>& continuation) {
  const auto prepared = in_memory(path)
                            ? Result<void>{}
                            : apply(database, kExclusive, path).and_then([&] { return make_durable(database, path); });
  return prepared.and_then([&] { return database.execute("BEGIN IMMEDIATE"); })
      .and_then([&] { return create_schema(database, info.thermometers); })
      .and_then([&] { return write_run_info(database, info); })
      .and_then([&] { return continuation ? write_continuation(database, *continuation) : Result<void>{}; })
      .and_then([&] { return database.execute("COMMIT"); });
}

void remove_all_of(const std::string& path) {
  for (const char* suffix : {"", "-wal", "-journal", "-shm"}) ::unlink((path + suffix).c_str());
}

Result<void> check_unfinished(Database& database, const std::string& path) {
  const auto finished = is_finished(database);
  if (!finished) return failure(finished.error());
  if (*finished) return failure(FaultKind::bad_file, path, "the run is finished, expected an unfinished one");
  const auto verdict = database.ask("PRAGMA quick_check(1)");
  if (!verdict) return failure(verdict.error());
  if (*verdict != "ok") return failure(FaultKind::storage, path, "the record is damaged: " + *verdict);
  return {};
}

std::string insert_sample_sql(const RunInfo& info) {
  const std::string columns = sample_columns(info.thermometers);
  std::string places = "?";
  for (const char c : columns)
    if (c == ',') places += ", ?";
  return fmt::format("INSERT INTO sample({}) VALUES({})", columns, places);
}

/// Puts the value, or NULL.
void put(Statement& statement, int parameter, const std::optional<Duration>& value) {
  if (value) return statement.put(parameter, value->count());
  statement.put(parameter, kMissing);
}

void put(Statement& statement, int first, const std::optional<Progress>& progress) {
  if (!progress) {
    for (int i = 0; i < 5; ++i) statement.put(first + i, kMissing);
    return;
  }
  statement.put(first, progress->segment);
  statement.put(first + 1, progress->cycle);
  statement.put(first + 2, name(progress->phase));
  statement.put(first + 3, progress->in_segment.count());
  statement.put(first + 4, progress->soaked.count());
}

}  // namespace

Result<RunFile::Statements> RunFile::prepare(Database& database, const RunInfo& info) {
  auto begin = database.prepare("BEGIN IMMEDIATE");
  if (!begin) return failure(begin.error());
  auto commit = database.prepare("COMMIT");
  if (!commit) return failure(commit.error());
  auto sample = database.prepare(insert_sample_sql(info));
  if (!sample) return failure(sample.error());
  auto fault = database.prepare("INSERT INTO fault(slot, channel, kind, \"where\", what) VALUES(?, ?, ?, ?, ?)");
  if (!fault) return failure(fault.error());
  auto event = database.prepare("INSERT INTO event(slot, monotonic_ns, utc_ns, kind, text) VALUES(?, ?, ?, ?, ?)");
  if (!event) return failure(event.error());
  auto gap = database.prepare("INSERT INTO gap(first, last, cause) VALUES(?, ?, ?)");
  if (!gap) return failure(gap.error());
  const auto has_frames = has_table(database, "frames");
  if (!has_frames) return failure(has_frames.error());
  std::optional<Statement> frames;
  if (*has_frames) {
    auto replace = database.prepare("INSERT OR REPLACE INTO frames(id, seen, lost, bad) VALUES(1, ?, ?, ?)");
    if (!replace) return failure(replace.error());
    frames = std::move(*replace);
  }
  return Statements{std::move(*begin), std::move(*commit), std::move(*sample), std::move(*fault),
                    std::move(*event), std::move(*gap),    std::move(frames)};
}

Result<RunFile> RunFile::ready(Database database, const std::string& path, RunInfo info) {
  auto statements = prepare(database, info);
  if (!statements) return failure(statements.error());
  if (in_memory(path)) return RunFile(std::move(database), std::move(*statements), {}, path, std::move(info));
  auto guard = WalGuard::find(path);
  if (!guard) return failure(guard.error());
  database.watch_log();
  if (auto folded = database.fold_log(); !folded) return failure(folded.error());  // what the file says of the run
  return RunFile(std::move(database), std::move(*statements), std::move(*guard), path, std::move(info));
}

Result<RunFile> RunFile::create(const std::string& path, const RunInfo& info,
                                const std::optional<Continuation>& continuation) {
  if (auto good = check_channel_names(info.thermometers); !good) return failure(good.error());
  if (!in_memory(path))
    if (auto made = make_new_file(path); !made) return failure(made.error());
  auto file = Database::open(path, Access::read_write, kPatienceMs).and_then([&](Database database) -> Result<RunFile> {
    if (auto filled = fill_new_file(database, path, info, continuation); !filled) {
      database.keep_log_on_close();
      return failure(filled.error());
    }
    return ready(std::move(database), path, info);
  });
  if (!file && !in_memory(path)) remove_all_of(path);
  return file;
}

Result<RunFile> RunFile::reopen(const std::string& path) {
  auto database = Database::open(path, Access::read_write, kPatienceMs);
  if (!database) return failure(database.error());
  const auto usable = apply(*database, kExclusive, path)
                          .and_then([&] { return check_schema(*database, path); })
                          .and_then([&] { return check_unfinished(*database, path); })
                          .and_then([&] { return make_durable(*database, path); });
  if (!usable) return failure(usable.error());
  // The log's index that somebody left who read the record in between; under the exclusive lock nobody uses it.
  std::error_code none_there;
  std::filesystem::remove(path + "-shm", none_there);
  auto info = read_run_info(*database);
  if (!info) return failure(info.error());
  return ready(std::move(*database), path, std::move(*info));
}

Result<void> RunFile::begin() { return statements_->begin.run(); }

Result<void> RunFile::commit() {
  return statements_->commit.run().and_then([this] { return check_log(); });
}

Result<void> RunFile::roll_back() {
  return database_.in_transaction() ? database_.execute("ROLLBACK") : Result<void>{};
}

Result<void> RunFile::fold_log() {
  return database_.log_pages() < kLongLogPages ? Result<void>{} : database_.fold_log();
}

Result<void> RunFile::insert(const Entry& entry) {
  Result<void> done;
  if (entry.sample) done = insert(*entry.sample);
  if (entry.is_gap()) done = insert_gap(entry.first, entry.last, entry.gap_cause);
  for (const auto& missing : entry.missing)
    if (done) done = insert_fault(entry.last, missing.channel, missing.fault);
  for (const Event& event : entry.events)
    if (done) done = insert_event(entry.last, event);
  return done;
}

Result<void> RunFile::insert(const SampleRow& row) {
  assert(row.thermometers_c.size() == info_.thermometers.size());
  Statement& sample = statements_->sample;
  sample.put(1, row.slot);
  sample.put(2, row.monotonic.count());
  put(sample, 3, row.utc);
  sample.put(4, row.progress ? row.progress->set_point.value : kMissing);
  sample.put(5, row.chamber_air_c);
  sample.put(6, row.chamber_set_point_c);
  int parameter = 7;
  for (const double reading_c : row.thermometers_c) sample.put(parameter++, reading_c);
  sample.put(parameter, row.gyro);
  put(sample, parameter + 1, row.interval);
  put(sample, parameter + 2, row.progress);
  return sample.run();
}

Result<void> RunFile::insert_fault(std::int64_t slot, std::string_view channel, const Fault& fault) {
  return statements_->fault.run(slot, channel, name(fault.kind), fault.where, fault.what);
}

Result<void> RunFile::insert_event(std::int64_t slot, const Event& event) {
  return statements_->event.run(slot, event.at.since_start.count(), event.at.utc.count(), name(event.kind), event.text);
}

Result<void> RunFile::insert_gap(std::int64_t first, std::int64_t last, std::string_view cause) {
  return statements_->gap.run(first, last, cause);
}

Result<void> RunFile::replace_frames(const FrameCount& frames) {
  return statements_->frames ? statements_->frames->run(frames.seen, frames.lost, frames.bad) : Result<void>{};
}

Result<void> RunFile::finish() {
  statements_.reset();
  if (in_memory(path_)) return mark_finished(database_);
  return mark_finished(database_)
      .and_then([this] { return check_log(); })
      .and_then([this] { return database_.ask("PRAGMA wal_checkpoint(TRUNCATE)"); })
      .and_then([this](const std::string& busy) -> Result<void> {
        if (busy == "0") return {};
        return failure(FaultKind::storage, path_, "the log could not be folded into the record");
      })
      .and_then([this] { return apply(database_, kOneFile, path_); });
}

}  // namespace gyrotherm
