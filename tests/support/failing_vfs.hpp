// SPDX-License-Identifier: Apache-2.0
/// A file system for SQLite that fails on command, and whose power can be cut.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

struct sqlite3_vfs;

namespace gyrotherm::tests {

/// While it lives, every database of the process is opened through it. Syncs cost nothing; what was not synced is
/// known.
class FailingVfs {
 public:
  enum class Kind {
    io_error,    ///< every operation may fail: open, read, write, truncate, sync, lock
    sync_error,  ///< syncs alone; what was to be synced is lost, although the next sync succeeds, as in Linux
    full,        ///< writes alone, for want of space
    power_cut,   ///< from then on nothing has any effect
    forgetful,   ///< writes alone: the disk says that they succeeded, and has other bytes
  };

  FailingVfs();
  ~FailingVfs();
  FailingVfs(const FailingVfs&) = delete;
  FailingVfs& operator=(const FailingVfs&) = delete;

  /// The operation with this number (from 1, counted from now) fails, once or with all that follow.
  void fail(std::int64_t operation, bool sticky, Kind kind);
  void heal() { fail_at_ = 0; }
  [[nodiscard]] std::int64_t operations() const { return operations_; }
  [[nodiscard]] std::int64_t failures() const { return failures_; }

  /// Makes every file what a power cut may leave of it: all that was synced, and of what was written after it whole
  /// sectors of 512 bytes, by chance. All files must be closed.
  void lose_what_was_not_synced(unsigned seed);

  /// For the file system itself: the code to fail with, or 0; of a write, whether the disk forgets it.
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
  std::atomic<std::int64_t> fail_at_{};  ///< healed while a worker writes
  bool sticky_{};
  Kind kind_{};
  std::map<std::string, File> disk_;
};

}  // namespace gyrotherm::tests
