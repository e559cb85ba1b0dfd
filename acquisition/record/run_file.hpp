// SPDX-License-Identifier: Apache-2.0
/// The open file of a run: one connection with the settings that make a commit durable, and one prepared statement per
/// kind of row. Store and import decide which rows are written; this class does not check their order.
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

/// Samples in the form in which the file stores them. A text in a cell refers to memory of its sample.
struct ChainedSamples {
  /// The cells of all samples, one sample after the other.
  std::vector<Cell> cells{};
  /// The links of the hash chain, one per sample.
  std::vector<std::int64_t> links{};
};

/// Writes one file of a record.
class RunFile {
 public:
  /// Creates a file with the schema and `info`. The file is durable when this function returns. Fails with storage if
  /// the file exists, with usage if the path contains a control character, and with bad_file if the name of a channel
  /// cannot be a column name. Leaves no file after a
  /// failure. The path kInMemory creates a database in memory.
  [[nodiscard]] static Result<RunFile> create(const std::string& path, const RunInfo& info,
                                              const std::optional<Continuation>& continuation = {});
  /// Opens the file of an unfinished run, and recovers the log if its writer died. Fails as Store::reopen() does.
  [[nodiscard]] static Result<RunFile> reopen(const std::string& path);

  /// Creates a record for rows that are all available. The file is locked exclusively. It is not watched, and it is
  /// synced only by finish(). After a crash of the machine the file is useless. Fails as create() does, and with usage
  /// if the path is kInMemory.
  [[nodiscard]] static Result<RunFile> create_at_once(const std::string& path, const RunInfo& info);

  /// Creates a file with the same tables for a live copy of a record. It is not locked, synced or watched. No other
  /// program may read it before share(). Fails as create() does.
  [[nodiscard]] static Result<RunFile> create_copy(const std::string& path, const RunInfo& info);
  /// Opens a copy on which share() has not been called, so no other program reads it.
  [[nodiscard]] static Result<RunFile> open_copy(const std::string& path);
  /// Switches a copy to WAL mode. From then on any program may read the copy.
  [[nodiscard]] Result<void> share();
  /// Copies all committed rows to the existing empty file `path`. Fails with storage.
  [[nodiscard]] Result<void> copy_to(const std::string& path);

  /// Tests whether the disk stores data: rewrites a row with the same values, syncs the file and reads the row back.
  /// Fails with storage.
  [[nodiscard]] Result<void> test_write();

  /// Begins a transaction. Fails without beginning one if another program changed the files; interference() then
  /// describes the change.
  [[nodiscard]] Result<void> begin();
  /// Commits the transaction. When it returns successfully, the rows are on the disk, in files that still have their
  /// names.
  [[nodiscard]] Result<void> commit();
  /// Returns the change that another program made to the files, or nothing if none was detected.
  [[nodiscard]] const std::optional<Interference>& interference() const { return interference_; }
  /// Rolls back the transaction if there is one.
  [[nodiscard]] Result<void> roll_back();
  /// Checkpoints the log if it has become long. Call it outside a transaction. Committed rows are on the disk with or
  /// without it.
  [[nodiscard]] Result<void> checkpoint_log();
  /// Keeps the file and its log unchanged from now on, even when the file is closed.
  void leave_untouched() { database_.keep_log_on_close(); }

  /// Writes all rows of an entry. Texts of faults, events and gaps come from instruments and operators; plain() removes
  /// their control characters.
  [[nodiscard]] Result<void> insert(const Entry& entry);
  [[nodiscard]] Result<void> insert(const SampleRow& row);
  /// The two halves of insert(), for many samples. chain() computes the links without access to the file. It can
  /// therefore process the next samples while another thread is in write(). Both must receive the samples in the same
  /// order.
  void chain(std::span<const SampleRow> rows, ChainedSamples& chained);
  [[nodiscard]] Result<void> write(const ChainedSamples& samples);
  [[nodiscard]] Result<void> insert_fault(std::int64_t slot, std::string_view channel, const Fault& fault);
  /// Writes an event. Uses the event's own number if it is higher than every earlier number, and otherwise the next
  /// number.
  [[nodiscard]] Result<void> insert_event(std::int64_t slot, const Event& event);
  /// Writes a decision and the segments that it adds. The link of the decision covers them. Writes no segment that the
  /// description of the file already contains.
  [[nodiscard]] Result<void> insert_decision(std::int64_t slot, const Event& decision,
                                             std::span<const RunInfo::SegmentInfo> segments);
  /// Copies the rows before `slot` from another open file of the same run.
  [[nodiscard]] Result<void> copy_rows(Database& other, std::int64_t slot);
  [[nodiscard]] Result<void> insert_gap(std::int64_t first, std::int64_t last, std::string_view cause);
  /// Stores the frame counts of the whole run, and the head of the chain. Call it last before a commit.
  [[nodiscard]] Result<void> replace_frames(const FrameCount& frames);

  /// Marks the run as finished and removes the log. One file remains. Call it outside a transaction. Afterwards the
  /// object may only be destroyed.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] const RunInfo& info() const { return info_; }
  /// Returns the highest event number; 0 if there is none.
  [[nodiscard]] std::int64_t last_event() const { return now_.events; }
  [[nodiscard]] Database& database() { return database_; }

 private:
  struct Statements {
    Statement begin{}, commit{}, sample{}, fault{}, event{}, gap{}, frames{};
    /// Inserts `rows_per_insert_` samples with the columns in `named_`. The statement `sample` inserts one.
    std::optional<Statement> samples{};
  };
  /// A row under construction. Each value is added to the statement and to the chain.
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
  [[nodiscard]] static Result<RunFile> make_open_file(Database database, const std::string& path, RunInfo info,
                                                      Watching watching);
  [[nodiscard]] static Result<RunFile> create_unsynced(const std::string& path, const RunInfo& info, bool claimed);
  [[nodiscard]] Result<void> seal();
  [[nodiscard]] Result<void> refuse_if(std::optional<Interference> found);
  [[nodiscard]] Result<void> copy_row(std::string_view table, const record::Statement& row);
  [[nodiscard]] std::int64_t chain_link(std::span<const Cell> sample);
  [[nodiscard]] Result<void> write_event(std::int64_t slot, const Event& event,
                                         std::span<const RunInfo::SegmentInfo> added);
  /// Prepares statements with only the columns that have had a value in any sample so far. Binding and storing NULL
  /// would take as long as a number.
  [[nodiscard]] Result<void> prepare_for(const ChainedSamples& samples);
  [[nodiscard]] Result<Statement> prepare_insert(const std::vector<bool>& named, std::size_t rows);

  /// Empty for a file in memory. Outlives the connection.
  std::optional<WrittenHere> written_;
  Database database_;
  /// Empty after finish().
  std::optional<Statements> statements_;
  /// Empty for a file in memory.
  std::optional<FileWatch> watch_;
  std::optional<Interference> interference_;
  /// commit() syncs the file before it returns.
  bool is_synced_ = true;
  std::string path_;
  RunInfo info_;
  SampleColumns columns_;
  /// One flag per column. Before the first sample, `sample` has all columns.
  std::vector<bool> named_{};
  std::size_t rows_per_insert_ = 1;
  ChainedSamples samples_{};  ///< reused
  /// The state of the file from which the next row continues.
  struct Position {
    RowChain chain;
    std::int64_t faults{}, events{};  ///< last keys
    /// Sizes of the lists in info_.
    std::size_t segments{}, blocks{};
  };
  Position now_;
  /// The state after the last commit, restored by a roll-back.
  Position committed_;
};

}  // namespace gyrotherm::record
