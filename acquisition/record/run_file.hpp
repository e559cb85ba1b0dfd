// SPDX-License-Identifier: Apache-2.0
/// The open file of a run: one connection with the settings that make a commit durable, and one prepared statement per
/// kind of row. What may be written when is the business of Store and of import; here a row is a row.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/file_watch.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// Samples as the file takes them. A text among the cells is not theirs.
struct ChainedSamples {
  std::vector<Cell> cells{};          ///< of one after the other
  std::vector<std::int64_t> links{};  ///< of the hash chain, one a sample
};

class RunFile {
 public:
  /// Makes a new file with its schema and `info`, durable when this returns. Fails with storage if the file exists,
  /// with bad_file if a channel's name cannot be a column. After a failure there is no file. kInMemory as a path is
  /// one.
  [[nodiscard]] static Result<RunFile> create(const std::string& path, const RunInfo& info,
                                              const std::optional<Continuation>& continuation = {});
  /// Takes up an unfinished run, folding in the log of a writer that died. Fails like Store::reopen().
  [[nodiscard]] static Result<RunFile> reopen(const std::string& path);

  /// Makes a new record whose rows are all at hand: claimed, but neither synced before finish(), which makes sure of
  /// all of it, nor watched. What a machine that dies leaves of it is of no use. Fails like create(), and with usage if
  /// the path is kInMemory.
  [[nodiscard]] static Result<RunFile> create_at_once(const std::string& path, const RunInfo& info);

  /// Makes a new file with the same tables that is no record but a copy of one, for others to read while the record is
  /// written: not claimed, not synced and not watched. Until share() nobody may read it; then everybody may, and it has
  /// a log. Fails like create().
  [[nodiscard]] static Result<RunFile> create_copy(const std::string& path, const RunInfo& info);
  /// Takes up a copy that nobody reads yet.
  [[nodiscard]] static Result<RunFile> open_copy(const std::string& path);
  [[nodiscard]] Result<void> share();
  /// Puts all that was committed to this file into a new one, which is there and empty. Fails with storage.
  [[nodiscard]] Result<void> copy_to(const std::string& path);

  /// Writes something that changes nothing, syncs it and reads it back from the file: nothing may depend on a record
  /// that was not seen to work. Fails with storage.
  [[nodiscard]] Result<void> prove();

  /// Fails also, with nothing begun, if another program has done something to the files; interference() says what.
  [[nodiscard]] Result<void> begin();
  /// Ends the transaction; once this returns it is on the disk, in files that are still in their places.
  [[nodiscard]] Result<void> commit();
  /// What another program did to the files, once it was found.
  [[nodiscard]] const std::optional<Interference>& interference() const { return interference_; }
  /// Nothing of the transaction remains, whether it was begun or not.
  [[nodiscard]] Result<void> roll_back();
  /// Outside a transaction: folds the log into the file once it is long. What was committed is on the disk either way.
  [[nodiscard]] Result<void> fold_log();
  /// From now on, and when it is closed, not a byte of the file and of its log changes.
  void leave_untouched() { database_.keep_log_on_close(); }

  /// Texts of faults, events and gaps come from instruments and operators: they are stored as plain() makes them.
  [[nodiscard]] Result<void> insert(const Entry& entry);
  [[nodiscard]] Result<void> insert(const SampleRow& row);
  /// The two halves of insert(), for many samples: the first touches no file, so that it can go on with the next while
  /// another thread is in the second, which has them in the same order.
  void chain(std::span<const SampleRow> rows, ChainedSamples& chained);
  [[nodiscard]] Result<void> write(const ChainedSamples& samples);
  [[nodiscard]] Result<void> insert_fault(std::int64_t slot, std::string_view channel, const Fault& fault);
  /// Under the event's number where it has one that is higher than all before, else under the next.
  [[nodiscard]] Result<void> insert_event(std::int64_t slot, const Event& event);
  /// Takes over the rows before `slot` of another file of the same run, which is open.
  [[nodiscard]] Result<void> copy_rows(Database& other, std::int64_t slot);
  [[nodiscard]] Result<void> insert_gap(std::int64_t first, std::int64_t last, std::string_view cause);
  /// Of the whole run so far, the last before a commit: the chain's head goes with it.
  [[nodiscard]] Result<void> replace_frames(const FrameCount& frames);

  /// Outside a transaction: marks the run as finished and makes the file a single one. Only destruction may follow.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] const RunInfo& info() const { return info_; }
  /// The highest number that an event has; 0: there is none.
  [[nodiscard]] std::int64_t last_event() const { return now_.events; }
  [[nodiscard]] Database& database() { return database_; }

 private:
  struct Statements {
    Statement begin{}, commit{}, sample{}, fault{}, event{}, gap{}, frames{};
    std::optional<Statement> samples{};  ///< as many as are put in together_; like `sample`, of the columns named_
  };
  /// A row being put together: each value goes into the statement and into the chain.
  class Row;
  RunFile(Database database, Statements statements, std::optional<FileWatch> watch, std::string path, RunInfo info)
      : database_(std::move(database)),
        statements_(std::move(statements)),
        watch_(std::move(watch)),
        path_(std::move(path)),
        info_(std::move(info)),
        columns_(info_) {}
  [[nodiscard]] static Result<Statements> prepare(Database& database, const RunInfo& info);
  enum class Watching { yes, no };
  [[nodiscard]] static Result<RunFile> ready(Database database, const std::string& path, RunInfo info,
                                             Watching watching);
  [[nodiscard]] static Result<RunFile> create_unsynced(const std::string& path, const RunInfo& info, bool claimed);
  [[nodiscard]] Result<void> seal();
  [[nodiscard]] Result<void> refuse_if(std::optional<Interference> found);
  [[nodiscard]] Result<void> copy_row(std::string_view table, const record::Statement& row);
  [[nodiscard]] std::int64_t link_of(std::span<const Cell> sample);
  /// The statements then name each column that some sample had something in so far: to bind and to store nothing takes
  /// as long as a number.
  [[nodiscard]] Result<void> prepare_for(const ChainedSamples& samples);
  [[nodiscard]] Result<Statement> prepare_insert(const std::vector<bool>& named, std::size_t rows);

  std::optional<WrittenHere> written_;  ///< nothing in memory; outlives the connection
  Database database_;
  std::optional<Statements> statements_;  ///< gone after finish()
  std::optional<FileWatch> watch_;        ///< nothing in memory
  std::optional<Interference> interference_;
  bool is_synced_ = true;  ///< a commit is on the disk when it returns
  std::string path_;
  RunInfo info_;
  SampleColumns columns_;
  std::vector<bool> named_{};  ///< of the columns; before the first sample `sample` has all of them
  std::size_t together_ = 1;
  ChainedSamples samples_{};  ///< made once
  /// What the next row continues.
  struct Position {
    RowChain chain;
    std::int64_t faults{}, events{};  ///< keys
  };
  Position now_;
  Position committed_;  ///< what a roll-back returns to
};

}  // namespace gyrotherm::record
