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

/// Default file system of SQLite during its lifetime. Files are never actually synced: the object only tracks which
/// writes would be lost in a power cut.
class FailingVfs {
 public:
  enum class Kind {
    /// Every operation may fail: open, read, write, truncate, sync, lock.
    io_error,
    /// Only syncs fail. As on Linux, the unsynced data is then lost although the next sync succeeds.
    sync_error,
    full,       ///< only writes fail: disk full
    power_cut,  ///< every later operation fails
    /// Writes report success but store zeros.
    forgetful,
  };

  FailingVfs();
  ~FailingVfs();
  FailingVfs(const FailingVfs&) = delete;
  FailingVfs& operator=(const FailingVfs&) = delete;

  /// Makes one operation fail, or that operation and all later ones (`sticky`). Operations are counted from 1 after
  /// this call.
  void fail(std::int64_t operation, bool sticky, Kind kind);
  void heal() { fail_at_ = 0; }
  [[nodiscard]] std::int64_t operations() const { return operations_; }
  [[nodiscard]] std::int64_t failures() const { return failures_; }

  /// Rewrites every file with a content that a power cut may leave: all synced data, and a random selection of the
  /// unsynced 512-byte sectors. All files must be closed.
  void lose_unsynced_data(unsigned seed);

  /// Counts an operation of the file system. Returns the SQLite error code with which it must fail, or 0.
  int count(char operation);
  /// Counts a write. Returns whether it must store zeros.
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
  std::atomic<std::int64_t> fail_at_{};  ///< 0: never; atomic for heal()
  bool sticky_{};
  Kind kind_{};
  std::map<std::string, File> disk_;
};

}  // namespace gyrotherm::tests
