/// The open file of a run: one connection with the settings that make a commit durable, and one prepared statement per
/// kind of row. What may be written when is the business of Store and of import; here a row is a row.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/entry.hpp"
#include "acquisition/row_chain.hpp"
#include "acquisition/run_info.hpp"
#include "acquisition/run_parts.hpp"
#include "acquisition/sqlite.hpp"
#include "acquisition/wal_guard.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm {

class RunFile {
 public:
  /// Makes a new file with its schema and `info`, durable when this returns. Fails with storage if the file exists,
  /// with bad_file if a channel's name cannot be a column. After a failure there is no file. kInMemory as a path is
  /// one.
  [[nodiscard]] static Result<RunFile> create(const std::string& path, const RunInfo& info,
                                              const std::optional<Continuation>& continuation = {});
  /// Takes up an unfinished run, folding in the log of a writer that died. Fails like Store::reopen().
  [[nodiscard]] static Result<RunFile> reopen(const std::string& path);

  [[nodiscard]] Result<void> begin();
  /// Ends the transaction; once this returns it is on the disk, in a log that is still in its place.
  [[nodiscard]] Result<void> commit();
  /// Nothing of the transaction remains, whether it was begun or not.
  [[nodiscard]] Result<void> roll_back();
  /// Outside a transaction: folds the log into the file once it is long. What was committed is on the disk either way.
  [[nodiscard]] Result<void> fold_log();
  /// From now on, and when it is closed, not a byte of the file and of its log changes.
  void leave_untouched() { database_.keep_log_on_close(); }

  [[nodiscard]] Result<void> insert(const Entry& entry);
  [[nodiscard]] Result<void> insert(const SampleRow& row);
  [[nodiscard]] Result<void> insert_fault(std::int64_t slot, std::string_view channel, const Fault& fault);
  [[nodiscard]] Result<void> insert_event(std::int64_t slot, const Event& event);
  [[nodiscard]] Result<void> insert_gap(std::int64_t first, std::int64_t last, std::string_view cause);
  /// Of the whole run so far, the last before a commit: the chain's head goes with it. A record of an older program has
  /// no place for it.
  [[nodiscard]] Result<void> replace_frames(const FrameCount& frames);

  /// Outside a transaction: marks the run as finished and makes the file a single one. Only destruction may follow.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] const RunInfo& info() const { return info_; }
  [[nodiscard]] Database& database() { return database_; }

 private:
  struct Statements {
    Statement begin, commit, sample, fault, event, gap;
    std::optional<Statement> frames;
  };
  /// A row being put together: each value goes into the statement and into the chain.
  class Row;
  RunFile(Database database, Statements statements, std::optional<WalGuard> guard, std::string path, RunInfo info)
      : database_(std::move(database)),
        statements_(std::move(statements)),
        guard_(std::move(guard)),
        path_(std::move(path)),
        info_(std::move(info)) {}
  [[nodiscard]] static Result<Statements> prepare(Database& database, const RunInfo& info, int version);
  [[nodiscard]] static Result<RunFile> ready(Database database, const std::string& path, RunInfo info);
  [[nodiscard]] Result<void> seal();
  [[nodiscard]] Result<void> check_log() const { return guard_ ? guard_->check() : Result<void>{}; }

  Database database_;
  std::optional<Statements> statements_;  ///< gone after finish()
  std::optional<WalGuard> guard_;         ///< nothing in memory
  std::string path_;
  RunInfo info_;
  /// What the next row continues.
  struct Position {
    std::optional<RowChain> chain;    ///< nothing: of an older program
    std::int64_t faults{}, events{};  ///< keys
  };
  Position now_;
  Position committed_;  ///< what a roll-back returns to
};

}  // namespace gyrotherm
