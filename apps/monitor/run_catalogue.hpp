// SPDX-License-Identifier: Apache-2.0
/// The runs in the folders of a monitor, and their status.
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
#include "apps/monitor/standard_answers.hpp"
#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// Trace that gyrotherm-make-safe leaves next to the record of a run whose program has ended. `gyrotherm resume`
/// removes it.
struct SafeTrace {
  /// Time of the action, UTC since 1970.
  Duration at{};
  Celsius set_point{};
  /// The chamber has shown the set point.
  bool confirmed{};
  /// An operator has ended the attempts.
  bool given_up{};
  bool operator==(const SafeTrace&) const = default;
};

/// A run whose record is in one of the folders.
struct FoundRun {
  /// Key of the run in addresses of the page: 16 hexadecimal digits, derived from the record's path.
  std::string key;
  /// Path of the record.
  std::string path;
  std::string name;
  record::RunStatus status;
  /// Time since the status was written. Empty if the run has ended, or if the machine was started since then.
  std::optional<double> age_s;
  /// Free space on the record's disk at the last scan; empty if unknown.
  std::optional<std::uint64_t> free_bytes;
  /// Action of gyrotherm-make-safe on the chamber of an unfinished run; empty if there is no trace of one.
  std::optional<SafeTrace> safe_trace{};
  /// Reason why the status cannot be read; empty if it can be read.
  std::string read_error;
  /// Changes when a member above changes, except age and free space, and when the run becomes silent.
  std::int64_t version{};
  /// Null if unreadable. Only the profile text is kept; other embedded files are dropped to save memory.
  std::shared_ptr<const record::RunInfo> info;
  /// What happens to the chamber after a stop and after an abort, such as "the chamber holds its present set point".
  std::string chamber_after_stop;
  std::string chamber_after_abort;
  /// Time for which the air of a chamber that is made safe is watched.
  Duration safe_observe{};
  /// History of check runs of the rig; empty if the rig has no check standard.
  std::optional<record::NamedHistory> standard{};
  /// Time from the first to the last row of an imported record, whose slots are row numbers; empty for another record.
  std::optional<Duration> imported_length{};
  /// Names of the channels of an imported record that have no value.
  std::vector<std::string> channels_without_values{};

  /// Returns the length of the run so far: the seconds up to the last sample, or the time of the rows if imported.
  [[nodiscard]] Duration length() const;
  /// Returns whether a program executes the run, according to the status.
  [[nodiscard]] bool is_running() const;
  /// Returns whether the program of the run has been silent for longer than record::kSilentAfter.
  [[nodiscard]] bool is_silent() const;
  /// Returns whether the run is unfinished and no program executes it, because its program has died or was interrupted.
  [[nodiscard]] bool is_abandoned() const;
};

/// The catalogue. Any thread may query it. Queries are answered from memory, so a folder that does not respond blocks
/// only the thread that scans it.
class RunCatalogue {
 public:
  explicit RunCatalogue(std::vector<std::string> folders);

  /// Scans one of folders(): adds new records, removes missing ones, and updates those whose files have changed.
  /// Returns early if `is_stopping` returns true.
  void scan_folder(const std::string& folder, const std::function<bool()>& is_stopping);
  /// Scans all folders, one after another.
  void scan(const std::function<bool()>& is_stopping = [] { return false; });

  /// Return the runs as of the last scan, with their present age, active ones first, then the newest first. An active
  /// run in a folder that does not respond becomes silent.
  [[nodiscard]] std::vector<FoundRun> runs() const;
  [[nodiscard]] std::optional<FoundRun> find(const std::string& key) const;
  [[nodiscard]] const std::vector<std::string>& folders() const { return folders_; }

 private:
  /// States of a run's files when they were last read.
  struct FileStates {
    FileState status, record, log, live_copy, safe_trace;
    bool operator==(const FileStates&) const = default;
  };
  struct Entry {
    FoundRun run;
    FileStates file_states;
    std::shared_ptr<const record::RunInfo> info;
    /// Id of the run that `info` describes.
    std::string info_id;
    std::string folder;
  };
  [[nodiscard]] static FileStates read_file_states(const std::string& path);
  [[nodiscard]] static FoundRun update_age(FoundRun run);
  [[nodiscard]] std::vector<std::string> active_records_in(const std::string& folder) const;
  [[nodiscard]] Entry copy_entry(const std::string& path) const;
  static void read_info(Entry& entry);
  void scan_record(const std::string& path, const std::string& folder, std::optional<std::uint64_t> free_bytes);

  std::vector<std::string> folders_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace gyrotherm::monitor
