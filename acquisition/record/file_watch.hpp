// SPDX-License-Identifier: Apache-2.0
/// Detects interference with the two files of a record being written, the database and its write-ahead log. Each file
/// must still exist under its name, in the folder of that name, and no other program may write it. Without this check,
/// a file that another program has unlinked would accept every commit and lose all of them, while SQLite reports
/// success.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

// The check of a write-ahead log against its own checksums. Without it, a foreign write would be noticed only after a
// crash or a power failure, when SQLite drops everything after it.

/// Returns whether the header and the first `frames` frames of an open log, written on this machine, are intact
/// (SQLite, "WAL-mode File Format" and "Checksum Algorithm"). Reads all of them: about 1 ms for 200 frames of 4 KiB.
[[nodiscard]] bool log_is_whole(int descriptor, std::int64_t frames);

// Checksums of a file's content, one per block, for detecting changes. After a write to a few positions of a large file
// only those blocks are summed again.

/// The checksums of one file.
class BlockSums {
 public:
  /// Computes the checksums of the first `length` bytes of an open file.
  [[nodiscard]] static BlockSums of(int descriptor, std::int64_t length);

  /// Updates the checksums after the file was written at these offsets and, possibly, extended to `length` bytes.
  void renew(int descriptor, std::int64_t length, std::span<const std::int64_t> offsets);
  bool operator==(const BlockSums&) const = default;

 private:
  void sum_block(int descriptor, std::int64_t block);

  std::int64_t length_ = 0;
  /// One checksum per block. It detects accidental changes, not deliberate ones. It is 0 if the block cannot be read.
  std::vector<std::uint64_t> sums_;
};

/// A change that another program made to a file of the record.
struct Interference {
  enum class Kind {
    /// Removed, moved or replaced. An open descriptor still reads the original content.
    taken_away,
    /// Truncated or overwritten.
    spoiled,
  };
  Kind kind{};
  /// The change affects only the log: everything already copied into the database is intact.
  bool is_log_only{};
  /// The description: "run.db was removed or moved by another program while it was being written".
  std::string description;
};

/// Watches the two files of one record.
class FileWatch {
 public:
  /// Finds the descriptors with which this process holds the two files. Call it after the first commit to the database
  /// at `path`. Opens neither file, because closing it again would release SQLite's locks. Fails with storage if a
  /// descriptor is not found.
  [[nodiscard]] static Result<FileWatch> begin(const std::string& path);

  /// Compares names, lengths and modification times with those at the last remember(). If only the time of the database
  /// differs, compares its content, because the file may merely have been touched. Call it before writing.
  [[nodiscard]] std::optional<Interference> check();
  /// Compares the names and, at most twice a second, the first `frames` frames of the log with their checksums. This
  /// detects writes of another program during a write of this process. Call it after writing.
  [[nodiscard]] std::optional<Interference> check_after_writing(std::int64_t frames);
  /// Compares only the log. Call it before the log is copied into the database.
  [[nodiscard]] std::optional<Interference> check_log(std::int64_t frames) const;
  /// Compares everything, including the checksums of the database. Call it before a record is declared complete.
  [[nodiscard]] std::optional<Interference> check_all(std::int64_t frames) const;
  /// Returns the offsets in the database that the log will overwrite.
  [[nodiscard]] std::vector<std::int64_t> offsets_in_log() const;
  /// Accept the present content as written by this process: that of the log; that of the log and of the database at
  /// `places`, the offsets that the log had before it was copied; or that of both files.
  void remember_log();
  void remember_fold(std::span<const std::int64_t> offsets);
  void remember();

 private:
  struct Snapshot {
    std::uint64_t device{}, inode{};
    std::int64_t length{}, written_ns{};
    /// The change time, for the database only. Unlike the modification time, no program can reset it.
    std::int64_t changed_ns{};
    bool operator==(const Snapshot&) const = default;
  };
  struct File {
    std::string name;  ///< relative to its folder
    int held{};        ///< SQLite's own descriptor
    Snapshot state;
    bool is_log{};
    BlockSums content;  ///< for the database only
  };
  FileWatch(std::string folder_path, std::shared_ptr<const Descriptor> folder, std::array<File, 2> files)
      : folder_path_(std::move(folder_path)), folder_(std::move(folder)), files_(std::move(files)) {}

  [[nodiscard]] static std::optional<Snapshot> read_state(const File& file);
  [[nodiscard]] static bool is_only_touched(File& file, const Snapshot& now);
  [[nodiscard]] std::optional<Interference> check_name(const File& file) const;
  [[nodiscard]] std::optional<Interference> check_folder() const;
  [[nodiscard]] std::optional<Interference> check_names() const;
  [[nodiscard]] static std::optional<Interference> check_content(File& file);

  std::string folder_path_;  ///< absolute path of the folder
  /// The folder that had this path at the beginning.
  std::shared_ptr<const Descriptor> folder_;
  std::array<File, 2> files_;
  SteadyClock clock_;
  /// The time of the last comparison of the log.
  std::optional<Duration> log_checked_;
};

}  // namespace gyrotherm::record
