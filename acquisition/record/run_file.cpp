// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <filesystem>
#include <utility>

#include "acquisition/record/decision.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/store.hpp"
#include "core/text.hpp"

namespace gyrotherm::record {
namespace {

bool in_memory(const std::string& path) { return path == kInMemory; }

Result<void> put_meta(Database& database, std::string_view key, std::string_view value) {
  auto insert = database.prepare("INSERT INTO meta(key, value) VALUES(?, ?)");
  return insert ? insert->run(key, value) : failure(insert.error());
}

Result<void> begin_chain(Database& database) {
  const auto start = description_hash(database);
  return start ? put_meta(database, "chain_start", hex(*start)) : failure(start.error());
}

/// Verifies the hash chain of the file and returns the chain. Fails with storage if it does not match.
Result<RowChain> read_chain(Database& database, const std::string& path) {
  auto checked = check_chain(database, path);
  if (!checked) return failure(FaultKind::storage, path, "the record is damaged: " + checked.error().what);
  return checked->chain;
}

Result<void> fill(Database& database, const RunInfo& info, const std::optional<Continuation>& continuation = {}) {
  return database.execute("BEGIN IMMEDIATE")
      .and_then([&] { return create_schema(database, info); })
      .and_then([&] { return write_run_info(database, info); })
      .and_then([&] { return continuation ? write_continuation(database, *continuation) : Result<void>{}; })
      .and_then([&] { return begin_chain(database); })
      .and_then([&] { return database.execute("COMMIT"); });
}

Result<void> fill_new_file(Database& database, const std::string& path, const RunInfo& info,
                           const std::optional<Continuation>& continuation) {
  const auto prepared = in_memory(path) ? Result<void>{}
                                        : lock_exclusively(database, path)
                                              .and_then([&] { return keep_journal_in_memory(database, path); })
                                              .and_then([&] { return make_durable(database, path); });
  return prepared.and_then([&] { return fill(database, info, continuation); });
}

void remove_with_logs(const std::string& path) {
  for (const char* suffix : {"", "-wal", "-journal", "-shm"}) ::unlink((path + suffix).c_str());
}

Result<void> check_unfinished(Database& database, const std::string& path) {
  const auto finished = is_finished(database);
  if (!finished) return failure(finished.error());
  if (*finished) return failure(FaultKind::bad_file, path, "the run is finished, expected an unfinished one");
  const auto verdict = database.query_text("PRAGMA quick_check(1)");
  if (!verdict) return failure(verdict.error());
  if (*verdict != "ok") return failure(FaultKind::storage, path, "the record is damaged: " + *verdict);
  return {};
}

constexpr int kCopyPatienceMs = 100;
/// Settings for a file that is useless after a crash of the machine.
constexpr const char* kUnsynced = "PRAGMA journal_mode = MEMORY; PRAGMA synchronous = OFF";

/// The most samples in one insert statement. Each execution has a fixed cost.
constexpr std::size_t kRowsPerInsert = 32;
constexpr std::size_t kMaxParameters = 32'766;  ///< SQLite's default limit

std::string insert_sql(std::string_view table, const std::string& columns, std::size_t rows = 1) {
  std::string placeholders = "?";
  for (const char c : columns)
    if (c == ',') placeholders += ", ?";
  std::string sql = fmt::format("INSERT INTO {}({}) VALUES({})", table, columns, placeholders);
  for (; rows > 1; --rows) sql += fmt::format(", ({})", placeholders);
  return sql;
}

}  // namespace

class RunFile::Row {
 public:
  Row(Statement& statement, RowChain& chain, std::string_view table) : statement_(statement), chain_(chain) {
    chain_.begin(table);
  }
  template <class T>
  Row& put(const T& value) {
    statement_.put(++parameter_, value);
    chain_.add(value);
    return *this;
  }
  Row& put(const char* value) { return put(std::string_view(value)); }
  Row& put(const std::string& value) { return put(std::string_view(value)); }
  Row& put(const Cell& cell) {
    return std::visit([this](auto value) -> Row& { return put(value); }, cell);
  }
  Result<void> run() {
    statement_.put(++parameter_, chain_.end());
    return statement_.run();
  }

 private:
  Statement& statement_;
  RowChain& chain_;
  int parameter_{};
};

Result<RunFile::Statements> RunFile::prepare(Database& database, const RunInfo& info) {
  const std::pair<Statement Statements::*, std::string> all[] = {
      {&Statements::begin, "BEGIN IMMEDIATE"},
      {&Statements::commit, "COMMIT"},
      {&Statements::sample, insert_sql("sample", SampleColumns(info).names() + ", chain")},
      {&Statements::fault, insert_sql("fault", "id, slot, channel, kind, \"where\", what, chain")},
      {&Statements::event, insert_sql("event", "id, " + column_names(event_columns()) + ", chain")},
      {&Statements::gap, insert_sql("gap", "first, last, cause, chain")},
      {&Statements::frames, "INSERT OR REPLACE INTO frames(id, seen, lost, bad, head) VALUES(1, ?, ?, ?, ?)"}};
  Statements prepared;
  for (const auto& [statement, sql] : all)
    if (auto made = assign_result(prepared.*statement, database.prepare(sql)); !made) return failure(made.error());
  return prepared;
}

Result<RunFile> RunFile::make_open_file(Database database, const std::string& path, RunInfo info, Watching watching) {
  Position end;
  Statements statements;
  const auto read =
      assign_result(end.chain, read_chain(database, path))
          .and_then(
              [&] { return assign_result(end.faults, database.query_integer("SELECT max(rowid) FROM fault", 0)); })
          .and_then([&] { return assign_result(end.events, database.query_integer("SELECT max(id) FROM event", 0)); })
          .and_then([&] { return assign_result(statements, prepare(database, info)); });
  if (!read) return failure(read.error());
  std::optional<FileWatch> watch;
  if (watching == Watching::yes && !in_memory(path)) {
    auto found = FileWatch::begin(path);
    if (!found) return failure(found.error());
    watch = std::move(*found);
    database.watch_log();
    // Checkpoint the description of the run. On a full disk it stays in the log.
    if (auto folded = database.empty_log(); !folded && !is_full(folded.error())) return failure(folded.error());
    watch->remember();
  }
  end.segments = info.segments.size();
  end.blocks = info.added_blocks.size();
  RunFile file(std::move(database), std::move(statements), std::move(watch), path, std::move(info));
  if (!in_memory(path)) file.written_.emplace(path);
  file.now_ = file.committed_ = end;
  return file;
}

Result<RunFile> RunFile::create(const std::string& path, const RunInfo& info,
                                const std::optional<Continuation>& continuation) {
  // A further part keeps the names of the record, which an earlier version may have permitted.
  if (auto good = continuation ? check_channel_names(info) : check_new_channel_names(info); !good)
    return failure(good.error());
  if (std::ranges::any_of(path, [](unsigned char c) { return c < ' '; }))
    return failure(FaultKind::usage, "record", "its name contains a control character, expected none");
  if (!in_memory(path))
    if (auto made = make_new_file(path); !made) return failure(made.error());
  auto file =
      Database::open(path, Access::read_write, kWriterPatienceMs).and_then([&](Database database) -> Result<RunFile> {
        if (auto filled = fill_new_file(database, path, info, continuation); !filled) {
          database.keep_log_on_close();
          return failure(filled.error());
        }
        return make_open_file(std::move(database), path, info, Watching::yes);
      });
  if (!file && !in_memory(path)) remove_with_logs(path);
  return file;
}

Result<RunFile> RunFile::reopen(const std::string& path) {
  if (auto alone = check_no_journal(path, path); !alone) return failure(alone.error());
  auto database = Database::open(path, Access::read_write, kWriterPatienceMs);
  if (!database) return failure(database.error());
  const auto usable = lock_exclusively(*database, path)
                          .and_then([&] { return check_schema(*database, path); })
                          .and_then([&] { return check_unfinished(*database, path); })
                          .and_then([&] { return make_durable(*database, path); });
  if (!usable) {
    database = failure(usable.error());  // closes it, which releases its locks
    if (is_locked(usable.error()) && !is_being_written(path)) return failure(FaultKind::timeout, path, kBeingRead);
    return failure(usable.error());
  }
  // Remove the index of the log that a reader may have left. No program uses the index while the exclusive lock is
  // held.
  std::error_code none_there;
  std::filesystem::remove(path + "-shm", none_there);
  auto info = read_run_info(*database);
  if (!info) return failure(info.error());
  return make_open_file(std::move(*database), path, std::move(*info), Watching::yes);
}

Result<RunFile> RunFile::create_unsynced(const std::string& path, const RunInfo& info, bool claimed) {
  if (auto made = make_new_file(path); !made) return failure(made.error());
  auto file = Database::open(path, Access::read_write, kCopyPatienceMs).and_then([&](Database database) {
    const auto filled = (claimed ? lock_exclusively(database, path) : Result<void>())
                            .and_then([&] { return database.execute(kUnsynced); })
                            .and_then([&] { return fill(database, info); });
    return filled ? make_open_file(std::move(database), path, info, Watching::no) : failure(filled.error());
  });
  if (!file) remove_with_logs(path);
  return file;
}

Result<RunFile> RunFile::create_at_once(const std::string& path, const RunInfo& info) {
  if (in_memory(path)) return failure(FaultKind::usage, "record", kNotAFileName);
  if (auto good = check_new_channel_names(info); !good) return failure(good.error());
  auto file = create_unsynced(path, info, true);
  if (file) file->is_synced_ = false;
  return file;
}

Result<RunFile> RunFile::create_copy(const std::string& path, const RunInfo& info) {
  return create_unsynced(path, info, false);
}

Result<RunFile> RunFile::open_copy(const std::string& path) {
  auto database = Database::open(path, Access::read_write, kCopyPatienceMs);
  if (!database) return failure(database.error());
  if (auto set = database->execute(kUnsynced); !set) return failure(set.error());
  auto info = read_run_info(*database);
  if (!info) return failure(info.error());
  return make_open_file(std::move(*database), path, std::move(*info), Watching::no);
}

Result<void> RunFile::share() {
  auto mode = database_.query_text("PRAGMA journal_mode = WAL");
  if (!mode) return failure(mode.error());
  if (*mode != "wal") return failure(FaultKind::storage, path_, "SQLite cannot switch it to a write-ahead log");
  database_.keep_log_on_close();
  if (auto set = database_.execute("PRAGMA wal_autocheckpoint = 0; PRAGMA journal_size_limit = 4194304"); !set)
    return set;
  database_.watch_log();  // execute() resets the hook
  return {};
}

Result<void> RunFile::copy_to(const std::string& path) {
  auto copy = database_.prepare("VACUUM INTO ?");
  return copy ? copy->run(std::string_view(name_for_sqlite(path))) : failure(copy.error());
}

Result<void> RunFile::refuse_if(std::optional<Interference> found) {
  if (found) interference_ = std::move(found);
  return interference_ ? failure(FaultKind::storage, path_, interference_->description) : Result<void>{};
}

Result<void> RunFile::begin() {
  if (watch_)
    if (auto refused = refuse_if(watch_->check()); !refused) return refused;
  return statements_->begin.run();
}

Result<void> RunFile::commit() {
  if (auto done = statements_->commit.run(); !done) return done;
  if (watch_) {
    if (auto refused = refuse_if(watch_->check_after_writing(database_.log_pages())); !refused) return refused;
    watch_->remember_log();
  }
  committed_ = now_;
  return {};
}

Result<void> RunFile::test_write() {
  if (in_memory(path_)) return {};
  constexpr const char* kFrames = "SELECT seen || ' ' || lost || ' ' || bad || ' ' || head FROM frames";
  const auto count = [this](const char* column) {
    return database_.query_integer(fmt::format("SELECT {} FROM frames", column), 0).value_or(0);
  };
  const FrameCount same{static_cast<std::uint64_t>(count("seen")), static_cast<std::uint64_t>(count("lost")),
                        static_cast<std::uint64_t>(count("bad"))};
  const auto done = begin().and_then([&] { return replace_frames(same); }).and_then([&] { return commit(); });
  if (!done) return done;
  database_.forget_pages();
  const auto found = database_.query_text(kFrames);
  if (!found) return failure(found.error());
  const auto wanted = fmt::format("{} {} {} {}", same.seen, same.lost, same.bad, hex(now_.chain.head()));
  if (*found == wanted) return {};
  return failure(FaultKind::storage, path_, "the data read back differ from the data written");
}

Result<void> RunFile::roll_back() {
  now_ = committed_;
  info_.segments.resize(now_.segments);
  info_.added_blocks.resize(now_.blocks);
  auto done = database_.in_transaction() ? database_.execute("ROLLBACK") : Result<void>{};
  if (watch_) watch_->remember_log();  // a failed transaction has written there
  return done;
}

Result<void> RunFile::checkpoint_log() {
  constexpr int kLongLogPages = 200;
  if (database_.log_pages() < kLongLogPages) return {};
  if (!watch_) return database_.checkpoint_log();
  if (auto refused = refuse_if(watch_->check_log(database_.log_pages())); !refused) return refused;
  const auto placeholders = watch_->offsets_in_log();
  auto done = database_.empty_log();
  watch_->remember_checkpoint(placeholders);
  return done;
}

Result<void> RunFile::insert(const Entry& entry) {
  Result<void> done;
  if (entry.sample) done = insert(*entry.sample);
  if (entry.is_gap()) done = insert_gap(entry.first, entry.last, entry.gap_cause);
  for (const auto& missing : entry.missing)
    if (done) done = insert_fault(entry.last, missing.channel, missing.fault);
  for (const Event& event : entry.events)
    if (done)
      done = is_decision(event) ? insert_decision(entry.last, event, entry.segments) : insert_event(entry.last, event);
  return done;
}

Result<void> RunFile::insert(const SampleRow& row) {
  chain({&row, 1}, samples_);
  return write(samples_);
}

void RunFile::chain(std::span<const SampleRow> rows, ChainedSamples& chained) {
  chained.cells.resize(rows.size() * columns_.count());
  chained.links.clear();
  std::span<Cell> left = chained.cells;
  for (const SampleRow& row : rows) {
    assert(row.thermometers_c.size() == info_.thermometers.size() && row.units.size() == info_.units.size());
    const auto cells = left.first(columns_.count());
    columns_.read_cells(row, cells);
    chained.links.push_back(chain_link(cells));
    left = left.subspan(cells.size());
  }
}

std::int64_t RunFile::chain_link(std::span<const Cell> sample) {
  now_.chain.begin("sample");
  for (const Cell& cell : sample) std::visit([&](auto value) { now_.chain.add(value); }, cell);
  return now_.chain.end();
}

Result<void> RunFile::write(const ChainedSamples& samples) {
  if (auto ready = prepare_for(samples); !ready) return ready;
  std::span<const Cell> cells = samples.cells;
  for (std::span<const std::int64_t> links = samples.links; !links.empty();) {
    const std::size_t rows = links.size() < rows_per_insert_ ? 1 : rows_per_insert_;
    auto& statement = rows == 1 ? statements_->sample : *statements_->samples;
    int parameter = 0;
    for (const std::int64_t link : links.first(rows)) {
      for (std::size_t i = 0; i < named_.size(); ++i)
        if (named_[i]) std::visit([&](auto value) { statement.put(++parameter, value); }, cells[i]);
      statement.put(++parameter, link);
      cells = cells.subspan(named_.size());
    }
    if (auto done = statement.run(); !done) return done;
    links = links.subspan(rows);
  }
  return {};
}

Result<void> RunFile::prepare_for(const ChainedSamples& samples) {
  auto named = named_;
  named.resize(columns_.count());
  for (std::span<const Cell> left = samples.cells; !left.empty(); left = left.subspan(named.size()))
    for (std::size_t i = 0; i < named.size(); ++i)
      if (!named[i]) named[i] = !is_null(left[i]);
  if (named != named_) {
    auto one = prepare_insert(named, 1);
    if (!one) return failure(one.error());
    statements_->sample = std::move(*one);
    statements_->samples.reset();
    const auto parameters = static_cast<std::size_t>(std::ranges::count(named, true)) + 1;
    rows_per_insert_ = std::clamp<std::size_t>(kMaxParameters / parameters, 1, kRowsPerInsert);
    named_ = std::move(named);
  }
  if (rows_per_insert_ == 1 || samples.links.size() < rows_per_insert_ || statements_->samples) return {};
  return assign_result(statements_->samples, prepare_insert(named_, rows_per_insert_));
}

Result<Statement> RunFile::prepare_insert(const std::vector<bool>& named, std::size_t rows) {
  std::string columns;
  std::size_t i = 0;
  columns_.each([&](std::string_view column, std::string_view) {
    if (named[i++]) columns += fmt::format("\"{}\", ", column);
  });
  return database_.prepare(insert_sql("sample", columns + "chain", rows));
}

Result<void> RunFile::insert_fault(std::int64_t slot, std::string_view channel, const Fault& fault) {
  return Row(statements_->fault, now_.chain, "fault")
      .put(++now_.faults)
      .put(slot)
      .put(channel)
      .put(name(fault.kind))
      .put(plain(fault.where))
      .put(plain(fault.what))
      .run();
}

Result<void> RunFile::insert_event(std::int64_t slot, const Event& event) { return write_event(slot, event, {}); }

Result<void> RunFile::insert_decision(std::int64_t slot, const Event& decision,
                                      std::span<const RunInfo::SegmentInfo> segments) {
  const auto first = static_cast<std::size_t>(decision.about.segment.value_or(0));
  const bool is_described = first < info_.segments.size();
  if (is_described) return write_event(slot, decision, {});
  for (std::size_t i = 0; i < segments.size(); ++i)
    if (auto written = write_segment(database_, first + i, segments[i]); !written) return written;
  add_block(info_, first, segments, decision.about.channel);
  now_.segments = info_.segments.size();
  now_.blocks = info_.added_blocks.size();
  return write_event(slot, decision, segments);
}

Result<void> RunFile::write_event(std::int64_t slot, const Event& event, std::span<const RunInfo::SegmentInfo> added) {
  RecordedEvent recorded{slot, event};
  recorded.event.text = plain(event.text);
  Row row(statements_->event, now_.chain, "event");
  now_.events = std::max(event.number, now_.events + 1);
  row.put(now_.events);
  for (const auto& column : event_columns()) row.put(column.cell(recorded));
  for (std::size_t i = 0; i < added.size(); ++i)
    chain_segment(now_.chain, info_.segments.size() - added.size() + i, added[i]);
  return row.run();
}

Result<void> RunFile::insert_gap(std::int64_t first, std::int64_t last, std::string_view cause) {
  return Row(statements_->gap, now_.chain, "gap").put(first).put(last).put(plain(cause)).run();
}

Result<void> RunFile::copy_row(std::string_view table, const record::Statement& row) {
  if (table == "sample") {
    samples_.cells.clear();
    for (int column = 0; column + 1 < row.columns(); ++column) samples_.cells.push_back(row.cell(column));
    samples_.links = {chain_link(samples_.cells)};
    return write(samples_);
  }
  auto& statement = table == "fault" ? statements_->fault : table == "event" ? statements_->event : statements_->gap;
  // Each part of a run numbers its faults from 1. Older versions also numbered the events of each part from 1.
  if (table == "fault") ++now_.faults;
  if (table == "event") now_.events = std::max(row.integer(0), now_.events + 1);
  const bool is_numbered = table != "gap";
  Row copy(statement, now_.chain, table);
  if (is_numbered) copy.put(table == "fault" ? now_.faults : now_.events);
  for (int column = is_numbered ? 1 : 0; column + 1 < row.columns(); ++column) copy.put(row.cell(column));
  return copy.run();
}

Result<void> RunFile::copy_rows(Database& other, std::int64_t slot) {
  return each_chained_row(other, info_, [&](std::string_view table, std::int64_t at, const Statement& row) {
    return at < slot ? copy_row(table, row) : Result<void>{};
  });
}

Result<void> RunFile::replace_frames(const FrameCount& frames) {
  return statements_->frames.run(frames.seen, frames.lost, frames.bad, hex(now_.chain.head()));
}

/// Stores the final hash of the chain and marks the run as finished.
Result<void> RunFile::seal() {
  auto frames = database_.prepare("SELECT max(seen), max(lost), max(bad) FROM frames");
  if (!frames) return failure(frames.error());
  if (const auto row = frames->step(); !row) return failure(row.error());
  const auto end = end_hash(now_.chain, frames->integer(0), frames->integer(1), frames->integer(2));
  frames = failure(FaultKind::storage, path_, "read");
  return database_.execute("BEGIN IMMEDIATE")
      .and_then([&] { return put_meta(database_, "chain_end", hex(end)); })
      .and_then([&] { return mark_finished(database_); })
      .and_then([&] { return database_.execute("COMMIT"); });
}

Result<void> RunFile::finish() {
  statements_.reset();
  if (in_memory(path_)) return seal();
  // The next commit must sync the whole file.
  if (!is_synced_)
    if (auto set = database_.execute("PRAGMA synchronous = FULL"); !set) return set;
  if (watch_)
    if (auto refused = refuse_if(watch_->check()); !refused) return refused;
  return seal()
      .and_then([this] { return watch_ ? refuse_if(watch_->check_all(database_.log_pages())) : Result<void>{}; })
      .and_then([this] { return database_.query_text("PRAGMA wal_checkpoint(TRUNCATE)"); })
      .and_then([this](const std::string& busy) -> Result<void> {
        if (busy == "0") return {};
        return failure(FaultKind::storage, path_, "the write-ahead log could not be copied into the record");
      })
      .and_then([this] { return keep_journal_in_memory(database_, path_); });
}

}  // namespace gyrotherm::record
