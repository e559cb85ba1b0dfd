// SPDX-License-Identifier: Apache-2.0
/// The runs that lie in the folders of a monitor, and where each stands.
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

/// A run as it was found. Plain; copies are handed out.
struct FoundRun {
  std::string key;   ///< of its address in the page: 16 hexadecimal digits, made of the record's path
  std::string path;  ///< of the record
  std::string name;  ///< "soak" of "soak.db"
  record::RunStatus status;
  std::optional<double> age_s;                  ///< since the status was written; nothing where no program writes it
  std::optional<std::uint64_t> free_bytes;      ///< on its disk when it was last looked at; nothing: unknown
  std::string trouble;                          ///< why its status cannot be told; empty: it can
  std::int64_t version{};                       ///< grows when anything above but age and free bytes changes
  std::shared_ptr<const record::RunInfo> info;  ///< null where it could not be read; of its texts the profile's alone
  std::string when_stopped;                     ///< the chamber after a stop
  std::string when_aborted;                     ///< the chamber after an abort

  /// Whether a program carries it out, and says so.
  [[nodiscard]] bool is_running() const;
  /// Whether a program has the record, and has been silent for longer than record::kSilentAfter.
  [[nodiscard]] bool is_silent() const;
  /// Whether it has not come to its end and no program carries it out: the one that did died, or was interrupted.
  [[nodiscard]] bool was_left() const;
};

/// Any thread may ask, and is answered from memory: a folder that does not answer holds only the thread that looks
/// there. Of each folder that is one.
class RunCatalogue {
 public:
  explicit RunCatalogue(std::vector<std::string> folders);

  /// Looks for new records in one of the folders(), and at those whose files have changed since; the rest of a look is
  /// left out once it `is_stopping`.
  void look_in(const std::string& folder, const std::function<bool()>& is_stopping);
  /// … in all of them in turn.
  void look(const std::function<bool()>& is_stopping = [] { return false; });

  /// As they were found by the last look, with the age of now: a run whose folder cannot be looked at falls silent.
  [[nodiscard]] std::vector<FoundRun> runs() const;  ///< running ones first, then by start, the newest first
  [[nodiscard]] std::optional<FoundRun> find(const std::string& key) const;
  [[nodiscard]] const std::vector<std::string>& folders() const { return folders_; }

 private:
  /// What a run's files looked like when they were last read.
  struct Stamp {
    FileState status, record, log, live_copy;
    bool operator==(const Stamp&) const = default;
  };
  struct Entry {
    FoundRun run;
    Stamp stamp;
    std::shared_ptr<const record::RunInfo> info;
    std::string info_of;  ///< the run's id
    std::string folder;   ///< it lies there
  };
  [[nodiscard]] static Stamp stamp_of(const std::string& path);
  [[nodiscard]] static FoundRun as_of_now(FoundRun run);
  [[nodiscard]] std::vector<std::string> running_in(const std::string& folder) const;
  [[nodiscard]] Entry entry_at(const std::string& path) const;
  static void read_info(Entry& entry);
  void look_at(const std::string& path, const std::string& folder, std::optional<std::uint64_t> free_bytes);

  std::vector<std::string> folders_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;  ///< by path
};

}  // namespace gyrotherm::monitor
