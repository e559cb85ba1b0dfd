// SPDX-License-Identifier: Apache-2.0
/// Maintains the live copy of a record that is being written. Other programs read the copy, because the writer locks
/// the record itself exclusively (docs/files.md). "RUN.live.db" is an ordinary SQLite file with the same schema. It is
/// at most two seconds behind the record.
///
/// Readers cannot disturb the run, because nothing in the run waits for them. The copy has a worker of its own. The
/// worker writes only acknowledged rows. It writes them to a write-ahead log, which no reader can block. A reader that
/// keeps a transaction open can only prevent the log from being restarted.
///
/// The worker starts a new file before the log becomes too long, if another program holds the lock of the copy, or if
/// the file was removed. "RUN.live.db" is a symbolic link to "RUN.live.db.1", then to "RUN.live.db.2", up to 9999.
/// SQLite names the log after the target of the link, so no reader combines one file with the log of another. The link
/// is replaced by a rename, and older files are removed. A reader that has an older file open can still read it to its
/// end.
///
/// If the disk accepts no data, or has only the space reserved for the record, the rows wait in memory. The copy is
/// removed if too many rows wait, if only an eighth of the reserved space is left, or if another program damaged the
/// copy. The run and its record are not affected, and trouble() reports the reason.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "acquisition/record/backlog.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

struct LiveCopyOptions {
  /// Minimum time between two transactions.
  Duration pause = std::chrono::milliseconds(500);
  /// The time from the start of the run to the start of its copy.
  Duration begins_after{};
  /// Maximum size of the log in bytes, and maximum time without a successful write. Beyond either limit, a new file is
  /// begun.
  std::int64_t longest_log = std::int64_t{48} << 20U;
  Duration longest_locked = std::chrono::seconds(3);
  /// Minimum time between the starts of two files.
  Duration rest = std::chrono::seconds(10);
  /// The maximum number of rows that wait in memory. If there are more, the copy ends.
  std::size_t most_rows = 50'000;
  /// The maximum number of pages of the file, to simulate a full disk; 0 means no limit.
  int most_pages{};
  /// The disk space in bytes that is reserved for the record.
  std::uintmax_t left_free = std::uintmax_t{256} << 20U;
};

/// The writer of a live copy. Its functions never fail, because a run must not end when it cannot be observed.
class LiveCopy {
 public:
  /// Begins the copy of a new record; add() supplies its rows. Removes an older copy immediately.
  LiveCopy(const std::string& record_path, const RunInfo& info, const LiveCopyOptions& options);
  /// Begins the copy of a resumed record with all rows in its files. No program may be writing them.
  [[nodiscard]] static std::unique_ptr<LiveCopy> for_existing_record(const RecordFiles& files, const RunInfo& info,
                                                                     const LiveCopyOptions& options);
  /// Removes the copy. Waits at most two seconds for the worker, and abandons it if the disk hangs.
  ~LiveCopy();
  LiveCopy(const LiveCopy&) = delete;
  LiveCopy& operator=(const LiveCopy&) = delete;

  /// Adds acknowledged rows, in order, and the present frame counts. Never waits. Any thread.
  void add(std::span<const EntryPointer> entries, const FrameCount& frames);
  /// Returns the reason why the copy is not up to date; empty if it is. Any thread.
  [[nodiscard]] std::string trouble() const;

 private:
  struct Worker;
  explicit LiveCopy(std::shared_ptr<Worker> worker);
  void start();
  std::shared_ptr<Worker> worker_;
};

}  // namespace gyrotherm::record
