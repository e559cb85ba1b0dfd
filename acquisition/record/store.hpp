// SPDX-License-Identifier: Apache-2.0
/// Writes the record of a run: one SQLite file and one connection. Acknowledges only rows that are synced (exclusive
/// locking before WAL, synchronous FULL, each setting read back).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

class Alarms;
class RecordWriter;
struct Record;
struct RunStatus;

inline constexpr const char* kRunSchema = "gyrotherm-run/1";

/// A path that creates a record in memory. The record ends with its store and has no status file.
inline constexpr const char* kInMemory = ":memory:";
/// The message for an operator who names a record kInMemory.
inline constexpr const char* kNotAFileName = "\":memory:\" is not accepted as a file name; write ./:memory:";

struct StoreOptions {
  /// Makes rows durable in a separate worker, which handles a full, slow or failing disk. Only settle() and finish()
  /// wait for the worker. Without a worker, each call does its own work, and after the first failure of the disk no row
  /// is acknowledged.
  bool background = false;
  /// The maximum number of rows in memory that wait for the disk, and the maximum number of acknowledged rows kept in
  /// memory: 4 h of each.
  std::int64_t most_rows = 14'400;
  /// The time between two attempts while the disk accepts no rows.
  Duration retry = std::chrono::seconds(1);
  /// Without a worker: minimum wall-clock time between two updates of the status file. The file is always updated at
  /// the end of the run.
  Duration status_interval = Duration::zero();
  /// The options of the live copy (live_copy.hpp). If they are not set, there is no live copy.
  std::optional<LiveCopyOptions> live_copy = {};
};

/// The condition of the disk and the delay of its writes.
struct StoreHealth {
  /// The number of seconds that are appended but not acknowledged.
  std::int64_t backlog_s{};
  /// Rows were dropped since the disk last accepted a row. In the record, gaps with this cause replace them.
  bool rows_dropped{};
  /// The reason why the disk accepts no rows; empty if it does.
  std::string trouble{};
  /// Number of files of the record. Every file after the first was begun because the previous one failed.
  int parts{1};
  /// The damage that another program did to the record's files; empty if there is none.
  std::string damage{};
  auto operator<=>(const StoreHealth&) const = default;
};

/// Writes the record of one run. Slots are appended in order, each as a sample or in a gap.
class Store {
 public:
  /// Creates a file and verifies that written data is read back. Removes the manifest of an earlier record of that
  /// name. Fails with storage if the file exists (a record is never overwritten) or cannot be made durable. In the
  /// second case no file remains.
  [[nodiscard]] static Result<std::unique_ptr<Store>> create(const std::string& path, const RunInfo& info,
                                                             const StoreOptions& options = {});
  /// Opens an unfinished run to continue it after its last row. Fails with bad_file if the file is not a record, has
  /// another version or is finished; with storage if it is damaged or another program is writing it; with timeout if
  /// another program is reading it, which is temporary.
  [[nodiscard]] static Result<std::unique_ptr<Store>> reopen(const std::string& path, const StoreOptions& options = {});
  virtual ~Store() = default;

  /// Appends a sample and its events to the open batch.
  [[nodiscard]] virtual Result<void> append(const Sample& sample, std::span<const Event> events) = 0;
  /// Appends a gap: slots first…last have no sample, because of `cause`.
  [[nodiscard]] virtual Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) = 0;
  /// Appends an event after the last slot.
  [[nodiscard]] virtual Result<void> append_event(const Event& event) = 0;
  /// Appends a decision (decision.hpp) after the last slot, and the segments that it adds to the profile. Both become
  /// durable together.
  [[nodiscard]] virtual Result<void> append_decision(const Event& decision,
                                                     std::span<const RunInfo::SegmentInfo> segments) = 0;
  /// Writes everything appended so far to the disk. With a worker, only starts the write. Returns the last slot
  /// acknowledged so far (−1 if none). Also updates the status file.
  [[nodiscard]] virtual Result<std::int64_t> sync() = 0;
  /// Syncs and waits at most `longest` until everything appended is acknowledged. Returns whether it is.
  [[nodiscard]] virtual bool settle(Duration longest) = 0;
  /// Marks the run as finished, checkpoints the log, closes the file and writes its manifest (chain.hpp). An unfinished
  /// run never has the mark. Fails with storage; with a worker also if rows still wait for the disk after 30 s.
  [[nodiscard]] virtual Result<void> finish() = 0;

  /// Sets the state of the run that the status file contains from the next sync on.
  virtual void publish(const RunOverview& overview) = 0;
  [[nodiscard]] virtual StoreHealth health() const = 0;
  /// Returns the alarms of everything appended so far, on the disk or not.
  [[nodiscard]] virtual const Alarms& alarms() const = 0;
  [[nodiscard]] virtual const RunInfo& info() const = 0;
  /// Reads everything appended so far. Works only without a worker, and is the only way to read a record in memory.
  /// Fails as read_record() does.
  [[nodiscard]] virtual Result<Record> read_back() = 0;
};

/// Removes a record that has no rows yet, with its log and its status file.
void remove_record(const std::string& path);

/// A store with the worker's handling of disk failures, but without threads. It is for callers with their own clock,
/// and has no status file.
struct AttendedStore {
  std::unique_ptr<Store> store;
  /// Executes the next transaction of the worker if one is requested or the last one failed. Must not be called after
  /// the store is destroyed.
  std::function<void()> attend;
};
[[nodiscard]] AttendedStore make_attended_store(RecordWriter writer, RunInfo info, const RunStatus& status,
                                                Alarms alarms, const StoreOptions& options);

}  // namespace gyrotherm::record
