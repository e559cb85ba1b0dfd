// SPDX-License-Identifier: Apache-2.0
/// The live copy of a record that is being written: what others read meanwhile, for the record itself is its writer's
/// alone (docs/files.md). "RUN.live.db" is an ordinary SQLite file of the same schema, at most two seconds behind.
///
/// Its readers may do what they like, for nothing of the run waits for them. A worker of the copy's own writes it, from
/// rows that are acknowledged already, and into a write-ahead log, which no reader can keep shut. Only a reader that
/// holds a transaction open keeps that log from starting anew. Before it is too long, and also where somebody holds the
/// copy's lock or has removed it, the copy is begun anew as another file. So that no reader ever joins one file with
/// another one's log, "RUN.live.db" is a link, and SQLite names the log after what it leads to: "RUN.live.db.1", then
/// "RUN.live.db.2", up to 9999. The link is replaced by rename, the files before are removed, and who has one open
/// still reads it to the end.
///
/// If its disk takes nothing, or has only what is left for the record, the copy waits, for as long as memory keeps
/// rows; with an eighth of that space it is taken away, and so is one that somebody has spoiled. The run and its record
/// are not touched, and trouble() says so.
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
  Duration pause = std::chrono::milliseconds(500);        ///< between two transactions, at least
  Duration begins_after{};                                ///< how old a run is before it gets one
  std::int64_t longest_log = std::int64_t{48} << 20U;     ///< bytes; after that the copy is begun anew
  Duration longest_locked = std::chrono::seconds(3);      ///< … and after so long in which it could not be written
  Duration rest = std::chrono::seconds(10);               ///< between two files, at least
  std::size_t most_rows = 50'000;                         ///< that wait in memory; of more there is no copy any more
  int most_pages{};                                       ///< of its file, as if its disk were full then; 0: any
  std::uintmax_t left_free = std::uintmax_t{256} << 20U;  ///< bytes of its disk, for the record
};

/// The writing end. It never fails: a run does not end because nobody can watch it.
class LiveCopy {
 public:
  /// Begins the copy of a new record, whose rows come by add(). What a copy left there before is removed at once.
  LiveCopy(const std::string& record_path, const RunInfo& info, const LiveCopyOptions& options);
  /// … of a record that is taken up again: with the rows that all its files hold, which nobody writes now.
  [[nodiscard]] static std::unique_ptr<LiveCopy> of_record(const RecordFiles& files, const RunInfo& info,
                                                           const LiveCopyOptions& options);
  /// Removes it. Waits at most two seconds for its worker, which is left behind if its disk hangs.
  ~LiveCopy();
  LiveCopy(const LiveCopy&) = delete;
  LiveCopy& operator=(const LiveCopy&) = delete;

  /// Rows that are acknowledged, in order, and the frames so far. Waits for nobody; any thread.
  void add(std::span<const EntryPointer> entries, const FrameCount& frames);
  /// Why it does not follow; empty: it does. Any thread.
  [[nodiscard]] std::string trouble() const;

 private:
  struct Worker;
  explicit LiveCopy(std::shared_ptr<Worker> worker);
  void start();
  std::shared_ptr<Worker> worker_;
};

}  // namespace gyrotherm::record
