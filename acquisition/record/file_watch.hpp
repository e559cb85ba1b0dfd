// SPDX-License-Identifier: Apache-2.0
/// Watches that the two files of a record being written, the database and its write-ahead log, are those that stand on
/// the disk under their names, in the folder that stands under its own, and that nobody else writes them. A file
/// unlinked by another program takes every commit and keeps none of them, while SQLite reports success.
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

// Whether a write-ahead log of SQLite still has what was written into it, by the sums in it. Without them a power cut
// or a crash would keep nothing behind the place where somebody else wrote, and nobody would know before.

/// Whether the header and the first `frames` frames of an open log, written on this machine, are whole (SQLite,
/// "WAL-mode File Format" and "Checksum Algorithm"). Reads all of them: about 1 ms for 200 frames of 4 KiB.
[[nodiscard]] bool log_is_whole(int descriptor, std::int64_t frames);

// Sums of a file's bytes, a block each, by which it is seen whether they are still what they were. After a write into
// some places of a large file only the blocks there are summed anew.

class BlockSums {
 public:
  /// Of the first `length` bytes of an open file.
  [[nodiscard]] static BlockSums of(int descriptor, std::int64_t length);

  /// The file was written to at these offsets, and now has `length` bytes; also where it grew.
  void renew(int descriptor, std::int64_t length, std::span<const std::int64_t> offsets);
  bool operator==(const BlockSums&) const = default;

 private:
  void sum_block(int descriptor, std::int64_t block);

  std::int64_t length_ = 0;
  std::vector<std::uint64_t> sums_;  ///< that anything but intent changes; 0 of a block that cannot be read
};

/// What another program did to a file of the record.
struct Interference {
  enum class Kind {
    taken_away,  ///< removed, moved or replaced: whoever has it open still sees what was written
    spoiled,     ///< cut short, or written to
  };
  Kind kind{};
  bool of_log{};      ///< of the log alone: what had been folded into the database is well
  std::string words;  ///< "run.db was removed or moved by another program while it was being written"
};

class FileWatch {
 public:
  /// To be called after the first commit to the database at `path`: finds the descriptors by which this process holds
  /// the two files, and opens neither (that would end SQLite's locks). Fails with storage if one is not found.
  [[nodiscard]] static Result<FileWatch> begin(const std::string& path);

  /// Compares names, lengths and times of writing with what they were at the last remember(), and the database's
  /// content where its time alone is another: somebody may merely have touched it. To be called before writing.
  [[nodiscard]] std::optional<Interference> look();
  /// Compares the names, and as often as twice a second the log of so many frames with the sums in it, which shows
  /// what somebody wrote while this process did. To be called after writing.
  [[nodiscard]] std::optional<Interference> look_after_writing(std::int64_t frames);
  /// Compares the log alone. To be called before it is folded in.
  [[nodiscard]] std::optional<Interference> look_at_log(std::int64_t frames) const;
  /// Compares everything, the database's content by its sums. To be called before a record is said to be whole.
  [[nodiscard]] std::optional<Interference> look_closely(std::int64_t frames) const;
  /// Where in the database the log has something to be folded in.
  [[nodiscard]] std::vector<std::int64_t> places_in_log() const;
  /// What stands there now was written by this process: in the log; in the database too, at the places that the log had
  /// before it was folded in; or wherever it may be.
  void remember_log();
  void remember_fold(std::span<const std::int64_t> places);
  void remember();

 private:
  struct Seen {
    std::uint64_t device{}, inode{};
    std::int64_t length{}, written_ns{};
    std::int64_t changed_ns{};  ///< of the database: what nobody can set back, as they can the time of writing
    bool operator==(const Seen&) const = default;
  };
  struct File {
    std::string name;  ///< in its folder
    int held{};        ///< the descriptor, SQLite's own
    Seen seen;
    bool is_log{};
    BlockSums content;  ///< of the database alone
  };
  FileWatch(std::string place, std::shared_ptr<const Descriptor> folder, std::array<File, 2> files)
      : place_(std::move(place)), folder_(std::move(folder)), files_(std::move(files)) {}

  [[nodiscard]] static std::optional<Seen> see(const File& file);
  [[nodiscard]] static bool was_merely_touched(File& file, const Seen& now);
  [[nodiscard]] std::optional<Interference> judge_name(const File& file) const;
  [[nodiscard]] std::optional<Interference> judge_folder() const;
  [[nodiscard]] std::optional<Interference> judge_names() const;
  [[nodiscard]] static std::optional<Interference> judge_content(File& file);

  std::string place_;                         ///< of the folder, from the root
  std::shared_ptr<const Descriptor> folder_;  ///< as it was found there
  std::array<File, 2> files_;
  SteadyClock clock_;
  std::optional<Duration> log_seen_;  ///< when the log's sums were last compared
};

}  // namespace gyrotherm::record
