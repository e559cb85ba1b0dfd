// SPDX-License-Identifier: Apache-2.0
/// Files of the operating system: open ones, whole ones that are read or replaced, and the entries of a folder. Whoever
/// reads may be handed anything under a name, and whoever writes may find that somebody else has put something there:
/// no function here waits for a pipe, reads a device, or writes through a link.
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

/// Owns an open file of the operating system and closes it.
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
  /// Gives the number away; whoever takes it owns it.
  [[nodiscard]] int release() && { return std::exchange(number_, kNoDescriptor); }
  void close() {
    if (is_open()) ::close(number_);
    number_ = kNoDescriptor;
  }

 private:
  int number_ = kNoDescriptor;
};

/// Reads as read(2) does, and reads again after a signal. Returns the number of bytes, 0 at the end, or -1 with errno.
[[nodiscard]] ssize_t read_some(int descriptor, void* to, std::size_t most);

/// Writes all bytes to a descriptor that blocks, and goes on after a signal. Returns false with errno if it cannot.
[[nodiscard]] bool write_all(int descriptor, std::string_view bytes);

/// The most bytes that are read: kLargestText of what people write and of what stands beside a record, kLargestTable
/// of a table, a model or a report.
inline constexpr std::size_t kLargestText = 4'000'000, kLargestTable = 256'000'000;

enum class Links { followed, refused };

/// An open file that is a regular one.
struct RegularFile {
  Descriptor descriptor;
  std::uint64_t size{};  ///< bytes, when it was opened
};

/// Opens a file to read it; nothing is waited for. Fails with bad_file if it is not there, cannot be read, or is no
/// regular file: a pipe, a device, a folder; with Links::refused also if the last part of the path is a link.
[[nodiscard]] Result<RegularFile> open_regular_file(const std::string& path, Links links = Links::followed);

/// Reads all of an open file, from its start; `path` names it in faults. Fails with bad_file if it has more than `most`
/// bytes, cannot be read, or has more or fewer bytes than it said: it changes, or is made while it is read, as /proc
/// is.
[[nodiscard]] Result<std::string> read_whole(const RegularFile& file, const std::string& path,
                                             std::size_t most = kLargestText);

/// Opens a regular file and reads all of it. Fails as open_regular_file() and read_whole() do.
[[nodiscard]] Result<std::string> read_text_file(const std::string& path, std::size_t most = kLargestText);

/// Does the same, and returns nothing if there is no file of that name. A link that leads nowhere is a file that cannot
/// be read.
[[nodiscard]] Result<std::optional<std::string>> read_text_file_if_any(const std::string& path,
                                                                       std::size_t most = kLargestText,
                                                                       Links links = Links::followed);

/// Replaces a file that the user named, as a whole: the text is written under a new name in the same folder, synced and
/// renamed; signals to this thread wait for that. A link's target is replaced, the link stays. The mode is 0644, less
/// what the umask takes. Fails with storage, also where the path is a device, a pipe or a folder.
[[nodiscard]] Result<void> replace_text_file(const std::string& path, std::string_view text);

enum class Syncing { awaited, not_awaited };

enum class Readers { owner_and_group, owner };

/// Replaces a file of our own, as one that stands beside a record: likewise as a whole, but what stands under the name
/// itself is replaced, a link as well, and never followed. The mode is 0640, or 0600 for the owner alone and where the
/// umask excludes the group (077); nothing else of the umask counts. `syncing` selects whether file and folder are
/// synced before this returns. Fails with storage.
[[nodiscard]] Result<void> replace_own_file(const std::string& path, std::string_view text,
                                            Syncing syncing = Syncing::awaited,
                                            Readers readers = Readers::owner_and_group);

/// The facts that tell one state of a file from another. File times are coarse: a file and its successor may have the
/// same time, but not the same inode.
struct FileState {
  std::uint64_t device{}, inode{};
  std::int64_t changed_ns{-1}, size{-1};
  bool operator==(const FileState&) const = default;
  [[nodiscard]] bool is_there() const { return size >= 0; }
};

/// Returns the state of the file that a path leads to, through links. Returns an empty state if there is no file.
[[nodiscard]] FileState read_file_state(const std::string& path);
/// Does the same without time and size, so that the state of a file that grows stays equal.
[[nodiscard]] FileState read_file_identity(const std::string& path);

/// The folder that a path lies in: "." of "rig.toml".
[[nodiscard]] std::string folder_of(const std::filesystem::path& path);

/// The paths of what lies in a folder, in no order; as many as could be read, none if it cannot be read at all. An
/// error on the way ends the list, as it may where a folder changes meanwhile; the increment of a
/// std::filesystem::directory_iterator would make an exception of it.
[[nodiscard]] std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder);

}  // namespace gyrotherm
