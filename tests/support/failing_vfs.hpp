// SPDX-License-Identifier: Apache-2.0
/// File system for SQLite that fails on command and simulates power cuts.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

struct sqlite3_vfs;

namespace gyrotherm::tests {

/// During its lifetime every database of the process is opened through it. A sync takes no time; unsynced writes are
/// tracked.
class FailingVfs {
 public:
  enum class Kind {
    /// Every operation may fail: open, read, write, truncate, sync, lock.
    io_error,
    /// Only syncs fail. The unsynced data is lost although the next sync succeeds, as on Linux.
    sync_error,
    full,       ///< only writes fail: disk full
    power_cut,  ///< later operations have no effect
    /// Writes report success and store other bytes.
    forgetful,
  };

  FailingVfs();
  ~FailingVfs();
  FailingVfs(const FailingVfs&) = delete;
  FailingVfs& operator=(const FailingVfs&) = delete;

  /// Makes an operation fail, once or together with all later ones. Operations are numbered from 1, starting with the
  /// first one after this call.
  void fail(std::int64_t operation, bool sticky, Kind kind);
  void heal() { fail_at_ = 0; }
  [[nodiscard]] std::int64_t operations() const { return operations_; }
  [[nodiscard]] std::int64_t failures() const { return failures_; }

  /// Sets every file to a content that a power cut may leave: all synced data, and a random selection of later 512-byte
  /// sectors. All files must be closed.
  void lose_unsynced_data(unsigned seed);

  /// Functions for the file system itself. count() returns the code to fail with, or 0; forgets() returns whether a
  /// write is lost.
  int count(char operation);
  bool forgets();
  void wrote(const std::string& path, std::int64_t offset, std::string bytes);
  void truncated(const std::string& path, std::int64_t size);
  void synced(const std::string& path);
  void failed_to_sync(const std::string& path) { disk_[path].pending.clear(); }
  void deleted(const std::string& path) { disk_.erase(path); }
  [[nodiscard]] sqlite3_vfs* below() const { return below_; }

 private:
  struct Change {
    std::int64_t offset{};
    std::string bytes;
    bool truncation{};
  };
  struct File {
    std::string durable;
    std::vector<Change> pending;
  };

  sqlite3_vfs* below_{};
  std::int64_t operations_{};
  std::int64_t failures_{};
  std::atomic<std::int64_t> fail_at_{};  ///< reset while a worker writes
  bool sticky_{};
  Kind kind_{};
  std::map<std::string, File> disk_;
};

}  // namespace gyrotherm::tests
