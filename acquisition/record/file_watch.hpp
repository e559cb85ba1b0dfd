// SPDX-License-Identifier: Apache-2.0
/// Detects interference by other programs with the two files of a record that is being written: the database and its
/// write-ahead log. Each file must keep its name, its folder must keep its path, and no other program may write the
/// file. Without this check, a file that another program has unlinked would lose every later commit, although SQLite
/// reports success.
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

// The check of a write-ahead log against its own checksums. Without it, a write by another program would be noticed
// only after a crash or a power failure, when SQLite drops everything in the log after that write.

/// Returns whether the header and the first `frames` frames of an open log, written on this machine, are intact
/// (SQLite, "WAL-mode File Format" and "Checksum Algorithm"). Reads all of them: about 1 ms for 200 frames of 4 KiB.
[[nodiscard]] bool is_log_intact(int descriptor, std::int64_t frames);

// Checksums of a file's content, one per block, for detecting changes. After a write to a few positions of a large
// file, only the checksums of those blocks are computed again.

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
    /// The file was removed, moved or replaced. An open descriptor still reads the original content.
    taken_away,
    /// The file was truncated or overwritten.
    spoiled,
  };
  Kind kind{};
  /// The change affects only the log. The content of the database is intact.
  bool is_log_only{};
  /// The description: "run.db was removed or moved by another program while it was being written".
  std::string description;
};

/// Watches the two files of one record.
class FileWatch {
 public:
  /// Finds the descriptors of the two files that this process has open. Call it after the first commit to the database
  /// at `path`. Opens neither file, because closing it again would release SQLite's locks. Fails with storage if a
  /// descriptor is not found.
  [[nodiscard]] static Result<FileWatch> begin(const std::string& path);

  /// Compares names, lengths and times of the files with the remembered ones. If only a time of the database differs,
  /// compares the content of the database, because the file may merely have been touched. Call it before writing.
  [[nodiscard]] std::optional<Interference> check();
  /// Compares the names. At most twice a second, also checks the first `frames` frames of the log against their
  /// checksums. This detects writes by another program during a write by this process. Call it after writing.
  [[nodiscard]] std::optional<Interference> check_after_writing(std::int64_t frames);
  /// Compares only the log. Call it before the log is copied into the database.
  [[nodiscard]] std::optional<Interference> check_log(std::int64_t frames) const;
  /// Compares everything, including the checksums of the database. Call it before a record is declared complete.
  [[nodiscard]] std::optional<Interference> check_all(std::int64_t frames) const;
  /// Returns the offsets in the database that the log will overwrite.
  [[nodiscard]] std::vector<std::int64_t> offsets_in_log() const;
  /// These functions store the present state of the files, as written by this process, for later checks. remember_log()
  /// stores the state of the log. remember_checkpoint() also stores the database blocks at `offsets`, which
  /// offsets_in_log() returned before the log was copied. remember() stores the state of both files.
  void remember_log();
  void remember_checkpoint(std::span<const std::int64_t> offsets);
  void remember();

 private:
  struct Snapshot {
    std::uint64_t device{}, inode{};
    std::int64_t length{}, written_ns{};
    /// The change time. No program can set it, unlike the modification time.
    std::int64_t changed_ns{};
    bool operator==(const Snapshot&) const = default;
  };
  struct File {
    std::string name;  ///< relative to its folder
    /// Descriptor that SQLite has open on the file; this object does not close it.
    int held{};
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
  /// The folder that had this path when the watch began.
  std::shared_ptr<const Descriptor> folder_;
  std::array<File, 2> files_;
  SteadyClock clock_;
  /// The time of the last comparison of the log.
  std::optional<Duration> log_checked_;
};

}  // namespace gyrotherm::record
