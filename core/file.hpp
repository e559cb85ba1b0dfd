// SPDX-License-Identifier: Apache-2.0
/// Functions that open, read and replace files and list folders. A path may lead to any kind of file, possibly created
/// by another program. Therefore no function here waits for a pipe, reads a device, or writes through a link that the
/// user did not name.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

inline constexpr int kNoDescriptor = -1;

/// Owns an open file descriptor and closes it.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, kNoDescriptor)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    close();
    number_ = std::exchange(other.number_, kNoDescriptor);
    return *this;
  }
  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }
  /// Releases the descriptor without closing it. The caller owns the returned number.
  [[nodiscard]] int release() && { return std::exchange(number_, kNoDescriptor); }
  void close() {
    if (is_open()) ::close(number_);
    number_ = kNoDescriptor;
  }

 private:
  int number_ = kNoDescriptor;
};

/// Reads as read(2) does, and reads again after EINTR. Returns the number of bytes, 0 at the end, or -1 with errno.
[[nodiscard]] ssize_t read_some(int descriptor, void* to, std::size_t most);

/// Writes all bytes to a blocking descriptor, and continues after EINTR. Returns false with errno on failure.
[[nodiscard]] bool write_all(int descriptor, std::string_view bytes);

/// Default limits for the size of a file, in bytes: kLargestText for texts that people write and for files next to a
/// record, kLargestTable for tables, models and reports.
inline constexpr std::size_t kLargestText = 4'000'000, kLargestTable = 256'000'000;

enum class Links { followed, refused };

/// A regular file, open for reading.
struct RegularFile {
  Descriptor descriptor;
  std::uint64_t size{};  ///< bytes when it was opened
};

/// Opens a regular file for reading without blocking. Fails with bad_file if it does not exist, cannot be read, or is a
/// pipe, a device or a folder. With Links::refused it also fails if the last component of the path is a symbolic link.
[[nodiscard]] Result<RegularFile> open_regular_file(const std::string& path, Links links = Links::followed);

/// Reads an open file from its start to its end; faults name it `path`. Fails with bad_file if the file has more than
/// `most` bytes or cannot be read. Also fails with bad_file if the number of bytes read differs from `file.size`: the
/// file is changing, or its content is generated on reading, as in /proc.
[[nodiscard]] Result<std::string> read_whole(const RegularFile& file, const std::string& path,
                                             std::size_t most = kLargestText);

/// Beginning of each SQLite database, such as a record.
inline constexpr std::string_view kSqliteBeginning = "SQLite format 3";
/// Returns whether a regular file begins with these bytes; false if there is no such file. Fails as
/// open_regular_file() does.
[[nodiscard]] Result<bool> begins_with(const std::string& path, std::string_view bytes);

/// Opens a regular file and reads all of it. Fails as open_regular_file() and read_whole() do.
[[nodiscard]] Result<std::string> read_text_file(const std::string& path, std::size_t most = kLargestText);

/// Reads as read_text_file() does, but returns an empty optional if no file of that name exists. Fails with bad_file
/// for a dangling link.
[[nodiscard]] Result<std::optional<std::string>> read_text_file_if_any(const std::string& path,
                                                                       std::size_t most = kLargestText,
                                                                       Links links = Links::followed);

/// Replaces a file that the user named: writes `text` to a new file in the same folder, syncs it and renames it.
/// Readers see either the old or the new content. Signals to this thread are blocked while the file is replaced. If the
/// path is a link, its target is replaced and the link remains. The mode is 0644, restricted by the umask. Fails with
/// storage, also if the path is a device, a pipe or a folder.
[[nodiscard]] Result<void> replace_text_file(const std::string& path, std::string_view text);

enum class Syncing { awaited, not_awaited };

enum class Readers { owner_and_group, owner };

/// Replaces a file that belongs to the program itself, such as one next to a record, in the same way. If the path is a
/// link, the link itself is replaced and never followed. The mode is 0640, or 0600 with Readers::owner or if the umask
/// excludes the group; the umask has no other effect. With Syncing::awaited, file and folder are synced before this
/// returns. Fails with storage.
[[nodiscard]] Result<void> replace_own_file(const std::string& path, std::string_view text,
                                            Syncing syncing = Syncing::awaited,
                                            Readers readers = Readers::owner_and_group);

/// State of a file, for detecting changes. The inode is part of it because file times are coarse: a file and its
/// replacement may have the same time, but they have different inodes. `size` is -1 if there is no file.
struct FileState {
  std::uint64_t device{}, inode{};
  std::int64_t changed_ns{-1}, size{-1};
  bool operator==(const FileState&) const = default;
  [[nodiscard]] bool is_there() const { return size >= 0; }
};

/// Returns the state of the file at `path`, following links. Returns an empty state if the file does not exist.
[[nodiscard]] FileState read_file_state(const std::string& path);
/// Returns the state with time and size set to 0. It remains the same while the file grows.
[[nodiscard]] FileState read_file_identity(const std::string& path);

/// Returns the folder that contains `path`: "." for "rig.toml".
[[nodiscard]] std::string parent_folder(const std::filesystem::path& path);

/// Returns the paths of the entries of a folder, unsorted. An error ends the list without an exception: the list is
/// empty if the folder cannot be read, and may be incomplete if the folder changes during the call.
[[nodiscard]] std::vector<std::filesystem::path> list_folder(const std::filesystem::path& folder);

}  // namespace gyrotherm
