// SPDX-License-Identifier: Apache-2.0
/// The record of a run being written: one SQLite file, one connection, nothing acknowledged that is not synced
/// (exclusive locking before WAL, synchronous FULL, each setting read back).
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

/// As a path: a record that lives in memory and ends with its store; it has no status file.
inline constexpr const char* kInMemory = ":memory:";
/// What whoever names the record of a run so is told.
inline constexpr const char* kNoNameOfAFile = "\":memory:\" is no name of a file here; ./:memory: is one";

struct StoreOptions {
  /// A worker of the store's own makes rows durable, and rides out a disk that is full, slow or failing: no call but
  /// settle() and finish() waits for it. Otherwise all is done inside the calls, and the first failure of the disk
  /// stays.
  bool background = false;
  /// Rows kept in memory, of those that wait for the disk and of those last acknowledged: 4 h.
  std::int64_t most_rows = 14'400;
  /// Between two attempts while the disk takes nothing.
  Duration retry = std::chrono::seconds(1);
  /// Inside the calls, the status file is written at most so often, by the clock on the wall, and at the end.
  Duration tells_every = Duration::zero();
  /// What others can read while the record is written (live_copy.hpp); nothing: they cannot.
  std::optional<LiveCopyOptions> live_copy = {};
};

/// How far the disk follows.
struct StoreHealth {
  std::int64_t backlog_s{};  ///< seconds appended and not acknowledged
  bool rows_dropped{};       ///< since the disk last took any; they are gaps with a cause
  std::string trouble{};     ///< why the disk takes no rows now; empty: it does
  int parts{1};              ///< files that the record consists of so far; each but the first followed a failure
  std::string damage{};      ///< what another program did to the record's files; empty: nothing
  auto operator<=>(const StoreHealth&) const = default;
};

class Store {
 public:
  /// Makes a new file, and sees that what is written to it is read back. Fails with storage if it exists (a record is
  /// never overwritten) or cannot be made durable; then there is none. The manifest of an earlier record of that name
  /// is removed.
  [[nodiscard]] static Result<std::unique_ptr<Store>> create(const std::string& path, const RunInfo& info,
                                                             const StoreOptions& options = {});
  /// Takes up an unfinished run, where it ended. Fails with bad_file (no record, other version, finished), storage
  /// (damaged, written by another) or timeout (read by another, who ends by and by).
  [[nodiscard]] static Result<std::unique_ptr<Store>> reopen(const std::string& path, const StoreOptions& options = {});
  virtual ~Store() = default;

  /// Puts a sample and its events into the open batch.
  [[nodiscard]] virtual Result<void> append(const Sample& sample, std::span<const Event> events) = 0;
  /// Slots first…last have no sample, and why.
  [[nodiscard]] virtual Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) = 0;
  [[nodiscard]] virtual Result<void> append_event(const Event& event) = 0;
  /// Makes everything appended durable, in the background only begins to; returns the last slot acknowledged by now
  /// (−1: none yet). Also refreshes the status file.
  [[nodiscard]] virtual Result<std::int64_t> sync() = 0;
  /// Syncs and waits, at most so long, until everything appended is acknowledged; whether it is.
  [[nodiscard]] virtual bool settle(Duration longest) = 0;
  /// Marks the run as finished, folds the log into the file, closes it and writes its manifest (chain.hpp). An
  /// unfinished run never carries the mark.
  /// Fails with storage, in the background also if rows are still waiting for the disk after 30 s.
  [[nodiscard]] virtual Result<void> finish() = 0;

  /// For the status file, from the next sync on.
  virtual void publish(const RunStanding& standing) = 0;
  [[nodiscard]] virtual StoreHealth health() const = 0;
  /// Of everything appended so far, on the disk or not.
  [[nodiscard]] virtual const Alarms& alarms() const = 0;
  [[nodiscard]] virtual const RunInfo& info() const = 0;
  /// Everything appended so far, of a store without a worker; the way to a record in memory. Fails like read_record().
  [[nodiscard]] virtual Result<Record> read_back() = 0;
};

/// Takes away a record that holds nothing yet, with its log and its status file.
void remove_record(const std::string& path);

/// A background store whose work is done by calls instead of workers, for whoever has a time of his own; it has no
/// status file.
struct AttendedStore {
  std::unique_ptr<Store> store;
  /// One transaction, if one is wanted or the last one failed. The store outlives it.
  std::function<void()> attend;
};
[[nodiscard]] AttendedStore make_attended_store(RecordWriter writer, RunInfo info, RunStatus status, Alarms alarms,
                                                const StoreOptions& options);

}  // namespace gyrotherm::record
