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
/// The message if an operator gives this path as the name of a record.
inline constexpr const char* kNotAFileName = "\":memory:\" is no name of a file here; ./:memory: is one";

struct StoreOptions {
  /// Makes rows durable in a separate worker, which handles a full, slow or failing disk. Only settle() and finish()
  /// wait for it. Without it, all work is done inside the calls, and the first failure of the disk is permanent.
  bool background = false;
  /// The number of rows kept in memory, both of those that wait for the disk and of those last acknowledged: 4 h.
  std::int64_t most_rows = 14'400;
  /// The time between two attempts while the disk accepts no rows.
  Duration retry = std::chrono::seconds(1);
  /// The least time between two updates of the status file, by the wall clock, without a worker. The end of the run
  /// always updates it.
  Duration status_interval = Duration::zero();
  /// The options of the live copy (live_copy.hpp); nothing for no live copy.
  std::optional<LiveCopyOptions> live_copy = {};
};

/// The delay and the condition of the disk.
struct StoreHealth {
  /// Seconds that are appended and not acknowledged.
  std::int64_t backlog_s{};
  /// Rows were dropped since the disk last accepted any. They are gaps with a cause.
  bool rows_dropped{};
  /// The reason why the disk accepts no rows; empty if it does.
  std::string trouble{};
  /// The number of files of the record. Each but the first follows a failure.
  int parts{1};
  /// The damage that another program did to the record's files; empty if there is none.
  std::string damage{};
  auto operator<=>(const StoreHealth&) const = default;
};

/// Writes the record of one run. Slots are appended in order, each as a sample or in a gap.
class Store {
 public:
  /// Creates a file and verifies that written data is read back. Removes the manifest of an earlier record of that
  /// name. Fails with storage if the file exists (a record is never overwritten) or cannot be made durable; then there
  /// is no file.
  [[nodiscard]] static Result<std::unique_ptr<Store>> create(const std::string& path, const RunInfo& info,
                                                             const StoreOptions& options = {});
  /// Opens an unfinished run to continue it after its last row. Fails with bad_file (not a record, another version,
  /// finished), storage (damaged, or being written by another program) or timeout (being read by another program, which
  /// will end).
  [[nodiscard]] static Result<std::unique_ptr<Store>> reopen(const std::string& path, const StoreOptions& options = {});
  virtual ~Store() = default;

  /// Appends a sample and its events to the open batch.
  [[nodiscard]] virtual Result<void> append(const Sample& sample, std::span<const Event> events) = 0;
  /// Appends a gap: slots first…last have no sample, because of `cause`.
  [[nodiscard]] virtual Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) = 0;
  /// Appends an event after the last slot.
  [[nodiscard]] virtual Result<void> append_event(const Event& event) = 0;
  /// Makes everything appended durable; with a worker, only starts to. Returns the last slot acknowledged so far (−1 if
  /// none). Also updates the status file.
  [[nodiscard]] virtual Result<std::int64_t> sync() = 0;
  /// Syncs and waits at most `longest` until everything appended is acknowledged. Returns whether it is.
  [[nodiscard]] virtual bool settle(Duration longest) = 0;
  /// Marks the run as finished, checkpoints the log, closes the file and writes its manifest (chain.hpp). An unfinished
  /// run never has the mark. Fails with storage; with a worker also if rows still wait for the disk after 30 s.
  [[nodiscard]] virtual Result<void> finish() = 0;

  /// Sets the state of the run that the status file shows from the next sync on.
  virtual void publish(const RunOverview& standing) = 0;
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

/// A background store that works in calls instead of threads, for callers with their own clock. It has no status file.
struct AttendedStore {
  std::unique_ptr<Store> store;
  /// Executes one transaction if one is requested or the last one failed. The store outlives it.
  std::function<void()> attend;
};
[[nodiscard]] AttendedStore make_attended_store(RecordWriter writer, RunInfo info, RunStatus status, Alarms alarms,
                                                const StoreOptions& options);

}  // namespace gyrotherm::record
