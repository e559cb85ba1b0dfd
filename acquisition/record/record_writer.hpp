// SPDX-License-Identifier: Apache-2.0
/// Makes entries durable whatever the disk does: one call is one transaction, and tells what came of it. One thread at
/// a time.
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
  std::size_t most_rows{};     ///< acknowledged rows that stay in memory, for a file that is found to have lost them
  int part{1};                 ///< of the file handed in
  int longest_locked{10};      ///< attempts on a file that another program holds
  std::int64_t last_slot{};    ///< that the file accounts for
  std::int64_t last_event{0};  ///< the highest number of an event in the record's other files
};

class RecordWriter {
 public:
  RecordWriter(RunFile file, std::string record_path, const RecordWriterOptions& options)
      : options_(options), path_(std::move(record_path)), info_(file.info()), file_(std::move(file)) {
    acknowledged_ = options.last_slot;
    last_event_ = std::max(options.last_event, file_->last_event());
  }

  /// Once it returns without a fault, the entries are on the disk. Otherwise none of them counts, and the same ones are
  /// to be handed in again later: on a full disk nothing else happens; a file that is locked for long, or that fails in
  /// any other way, is left untouched from then on, and a new part begins with the rows that are still in memory.
  [[nodiscard]] Result<void> write(std::span<const EntryPointer> entries, const FrameCount& frames);
  /// Marks the run as finished, closes it and writes its manifest, which a record of which another program has spoiled
  /// a file does not get; only destruction may follow.
  [[nodiscard]] Result<void> finish();

  /// What another program did to the record's files, in words; empty: nothing.
  [[nodiscard]] const std::string& damage() const { return damage_; }
  /// … and a file of which the record consists was spoiled by it. What was in that file is in the next one: all of it
  /// where the file could still be read, else as much as was in memory.
  [[nodiscard]] bool is_spoiled() const { return spoiled_; }

  /// The first slot that the last part accounts for.
  [[nodiscard]] std::int64_t from() const { return from_; }

  [[nodiscard]] std::int64_t acknowledged() const { return acknowledged_; }
  /// The highest number that an event has in any of the record's files.
  [[nodiscard]] std::int64_t last_event() const { return last_event_; }
  [[nodiscard]] int part() const { return options_.part; }
  /// Between two parts there is none.
  [[nodiscard]] RunFile* file() { return file_ ? &*file_ : nullptr; }
  /// Whether the fault will pass by itself, so that trying again at once is of no use.
  [[nodiscard]] static bool will_pass(const Fault& fault);

 private:
  std::int64_t first_to_account_for();
  Result<void> begin_part(std::span<const EntryPointer> entries, const FrameCount& frames);
  Result<void> fill_part(RunFile& file, const Continuation& continuation, std::span<const EntryPointer> entries);
  Result<void> put(std::span<const EntryPointer> entries, const FrameCount& frames);
  Result<void> judge(Fault fault);
  void keep(std::span<const EntryPointer> entries);
  void give_up(const Fault& why);

  RecordWriterOptions options_;
  std::string path_;  ///< of the record; its parts stand beside it
  RunInfo info_;
  std::optional<RunFile> file_;
  std::string failed_;               ///< why the part before was left
  std::optional<RunFile> nameless_;  ///< the part before, if its name was taken from it: it can still be read
  std::optional<RunFile> left_;  ///< any other part before: until the next one is there it tells that a program writes
  std::string damage_;
  bool spoiled_ = false;
  std::deque<EntryPointer> kept_;  ///< acknowledged; begins with one that accounts for slots
  std::int64_t from_{};
  std::int64_t acknowledged_{-1};
  std::int64_t last_event_{};  ///< acknowledged, too
  int locked_{};               ///< attempts in a row
};

}  // namespace gyrotherm::record
