// SPDX-License-Identifier: Apache-2.0
/// Writes entries durably despite failures of the disk. Each call is one transaction and returns its result. One thread
/// at a time may use a writer.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "acquisition/record/backlog.hpp"
#include "acquisition/record/run_file.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

struct RecordWriterOptions {
  /// The number of acknowledged rows kept in memory. A new part begins with them, because the failed file may have lost
  /// them.
  std::size_t most_rows{};
  /// Part number of the file that is passed to the constructor.
  int part{1};
  /// Number of consecutive failed attempts after which a locked file is abandoned.
  int longest_locked{10};
  /// The last slot in the file passed to the constructor.
  std::int64_t last_slot{};
  /// The highest event number in the other files of the record.
  std::int64_t last_event{0};
};

/// Writes one record, in as many parts as failures require.
class RecordWriter {
 public:
  RecordWriter(RunFile file, std::string record_path, const RecordWriterOptions& options)
      : options_(options), path_(std::move(record_path)), info_(file.info()), file_(std::move(file)) {
    acknowledged_ = options.last_slot;
    last_event_ = std::max(options.last_event, file_->last_event());
  }

  /// Writes the entries in one transaction. After a success, all entries are on the disk. After a failure, none
  /// is, and the caller must pass the same entries again later. After a full disk, the same file is used again. After
  /// any other failure, or a long lock, the present file is left untouched, and the next call begins a new part with
  /// the rows that are still in memory.
  [[nodiscard]] Result<void> write(std::span<const EntryPointer> entries, const FrameCount& frames);
  /// Marks the run as finished, closes the file and writes its manifest. If another program has changed or removed the
  /// file since the last row, finishes a new part with its rows. Writes no manifest if another program damaged a file
  /// of the record. Afterwards the object may only be destroyed.
  [[nodiscard]] Result<void> finish();

  /// Describes the damage that another program did to the record's files; empty if there is none.
  [[nodiscard]] const std::string& damage() const { return damage_; }
  /// Returns whether another program changed or removed a file of the record. The next part then has all rows of that
  /// file if it could still be read, and otherwise the rows that were in memory.
  [[nodiscard]] bool is_damaged() const { return spoiled_; }

  /// Returns the first slot of the last part.
  [[nodiscard]] std::int64_t from() const { return from_; }

  /// Returns the last slot that is on the disk.
  [[nodiscard]] std::int64_t acknowledged() const { return acknowledged_; }
  /// Returns the highest event number in all files of the record.
  [[nodiscard]] std::int64_t last_event() const { return last_event_; }
  [[nodiscard]] int part() const { return options_.part; }
  /// Returns the open file, or null between two parts.
  [[nodiscard]] RunFile* file() { return file_ ? &*file_ : nullptr; }
  /// Returns whether a fault is temporary: a full disk or a locked file. An immediate second attempt is then useless.
  [[nodiscard]] static bool is_temporary(const Fault& fault);

 private:
  std::int64_t first_to_account_for();
  Result<void> begin_part(std::span<const EntryPointer> entries, const FrameCount& frames);
  Result<void> fill_part(RunFile& file, const Continuation& continuation, std::span<const EntryPointer> entries);
  Result<void> write_transaction(std::span<const EntryPointer> entries, const FrameCount& frames);
  Result<void> handle_failure(Fault fault);
  void keep(std::span<const EntryPointer> entries);
  void give_up(const Fault& why);

  RecordWriterOptions options_;
  std::string path_;  ///< the record
  RunInfo info_;
  std::optional<RunFile> file_;
  /// The reason why the previous part was abandoned.
  std::string failed_;
  /// The previous part if its name was removed; it can still be read.
  std::optional<RunFile> nameless_;
  /// The previous part in any other case. Until the next part exists, the lock on this file shows that a program is
  /// writing the record.
  std::optional<RunFile> left_;
  std::string damage_;
  bool spoiled_ = false;
  /// The acknowledged rows in memory. The first entry is never an event without a slot.
  std::deque<EntryPointer> kept_;
  FrameCount frames_;  ///< counts of the last transaction
  std::int64_t from_{};
  /// The last slot and the highest event number that are acknowledged.
  std::int64_t acknowledged_{-1};
  std::int64_t last_event_{};
  /// Consecutive attempts on a locked file.
  int locked_{};
};

}  // namespace gyrotherm::record
