// SPDX-License-Identifier: Apache-2.0
/// The runs in the folders of a monitor, with their state.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/status.hpp"
#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// A run found in a folder. A plain value that is copied to callers.
struct FoundRun {
  /// Key in the page's addresses: 16 hexadecimal digits, derived from the record's path.
  std::string key;
  /// Path of the record.
  std::string path;
  std::string name;
  record::RunStatus status;
  /// Time since the status was written; empty if no program writes it.
  std::optional<double> age_s;
  /// Free space on the record's disk at the last check; empty if unknown.
  std::optional<std::uint64_t> free_bytes;
  /// Reason why the status cannot be read; empty if it can.
  std::string trouble;
  /// Incremented when a member above changes, except age and free bytes.
  std::int64_t version{};
  /// Null if unreadable. Only the profile text is kept; other embedded files are dropped to save memory.
  std::shared_ptr<const record::RunInfo> info;
  /// State of the chamber after a stop and after an abort.
  std::string chamber_after_stop;
  std::string chamber_after_abort;

  /// Returns whether a program executes the run, according to the status.
  [[nodiscard]] bool is_running() const;
  /// Returns whether the program of the run has been silent for longer than record::kSilentAfter.
  [[nodiscard]] bool is_silent() const;
  /// Returns whether the run has not ended but no program executes it: its program died or was interrupted.
  [[nodiscard]] bool was_abandoned() const;
};

/// The catalogue. Any thread may query it. Queries are answered from memory: a folder that does not respond blocks only
/// the one thread that reads it.
class RunCatalogue {
 public:
  explicit RunCatalogue(std::vector<std::string> folders);

  /// Finds new records in one of the folders(), and updates records with changed files. Returns early if `is_stopping`.
  void scan_folder(const std::string& folder, const std::function<bool()>& is_stopping);
  /// Checks all folders one after another.
  void scan(const std::function<bool()>& is_stopping = [] { return false; });

  /// Return runs as found by the last check, with their present age. A run in a folder that does not respond becomes
  /// silent.
  [[nodiscard]] std::vector<FoundRun> runs() const;
  [[nodiscard]] std::optional<FoundRun> find(const std::string& key) const;
  [[nodiscard]] const std::vector<std::string>& folders() const { return folders_; }

 private:
  /// State of a run's files when they were last read.
  struct Stamp {
    FileState status, record, log, live_copy;
    bool operator==(const Stamp&) const = default;
  };
  struct Entry {
    FoundRun run;
    Stamp stamp;
    std::shared_ptr<const record::RunInfo> info;
    /// Id of the run that `info` describes.
    std::string info_id;
    std::string folder;
  };
  [[nodiscard]] static Stamp read_stamp(const std::string& path);
  [[nodiscard]] static FoundRun with_current_age(FoundRun run);
  [[nodiscard]] std::vector<std::string> active_records_in(const std::string& folder) const;
  [[nodiscard]] Entry copy_entry(const std::string& path) const;
  static void read_info(Entry& entry);
  void scan_record(const std::string& path, const std::string& folder, std::optional<std::uint64_t> free_bytes);

  std::vector<std::string> folders_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace gyrotherm::monitor
