/// The record of a run being written: one SQLite file, one connection, nothing acknowledged that is not synced
/// (reliability rules: exclusive locking before WAL, synchronous FULL, each setting read back).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "acquisition/run_info.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm {

inline constexpr const char* kRunSchema = "gyrotherm-run/1";

class Store {
 public:
  /// Makes a new file. Fails with storage if it exists (a record is never overwritten) or cannot be made durable.
  [[nodiscard]] static Result<std::unique_ptr<Store>> create(const std::string& path, const RunInfo& info);
  /// Takes up an unfinished run. Fails with bad_file (no record, other version, finished) or storage (damaged, locked
  /// by another).
  [[nodiscard]] static Result<std::unique_ptr<Store>> reopen(const std::string& path);
  virtual ~Store() = default;

  /// Puts a sample and its events into the open batch.
  [[nodiscard]] virtual Result<void> append(const Sample& sample, std::span<const Event> events) = 0;
  /// Slots first…last have no sample, and why.
  [[nodiscard]] virtual Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) = 0;
  [[nodiscard]] virtual Result<void> append_event(const Event& event) = 0;
  /// Makes everything appended durable; returns the last slot acknowledged (−1: none yet). Also refreshes the status
  /// file.
  [[nodiscard]] virtual Result<std::int64_t> sync() = 0;
  /// Marks the run as finished, folds the log into the file and closes. An unfinished run never carries the mark.
  [[nodiscard]] virtual Result<void> finish() = 0;

  [[nodiscard]] virtual const RunInfo& info() const = 0;
};

}  // namespace gyrotherm
