// SPDX-License-Identifier: Apache-2.0
#include "core/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <system_error>

namespace gyrotherm {
namespace {

tl::unexpected<Fault> read_failure(const std::string& path, const std::string& why) {
  return failure(FaultKind::bad_file, path, "cannot be read: " + why);
}

const char* file_type_name(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  if (S_ISLNK(mode)) return "a link";
  return "a device";
}

tl::unexpected<Fault> wrong_type_failure(const std::string& path, mode_t mode) {
  return failure(FaultKind::bad_file, path, fmt::format("is {}, expected a regular file", file_type_name(mode)));
}

/// Reads until `size` bytes are read or the file ends. Returns false with errno set on failure.
bool read_up_to(int file, std::string& into, std::size_t size) {
  into.resize(size);
  std::size_t taken = 0;
  while (taken < size) {
    const auto count = ::pread(file, into.data() + taken, size - taken, static_cast<off_t>(taken));
    if (count < 0 && errno != EINTR) return false;
    if (count == 0) break;
    if (count > 0) taken += static_cast<std::size_t>(count);
  }
  into.resize(taken);
  return true;
}

}  // namespace

ssize_t read_some(int descriptor, void* to, std::size_t most) {
  while (true) {
    const auto count = ::read(descriptor, to, most);
    if (count >= 0 || errno != EINTR) return count;
  }
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const auto written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Result<RegularFile> open_regular_file(const std::string& path, Links links) {
  const bool follows = links == Links::followed;
  struct stat info {};
  // Check before opening: opening some devices has side effects.
  if (::fstatat(AT_FDCWD, path.c_str(), &info, follows ? 0 : AT_SYMLINK_NOFOLLOW) != 0)
    return read_failure(path, std::strerror(errno));
  if (!S_ISREG(info.st_mode)) return wrong_type_failure(path, info.st_mode);
  const int flags = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | (follows ? 0 : O_NOFOLLOW);
  RegularFile file{.descriptor = Descriptor(::open(path.c_str(), flags))};
  if (!file.descriptor.is_open() || ::fstat(file.descriptor.number(), &info) != 0)
    return read_failure(path, std::strerror(errno));
  if (!S_ISREG(info.st_mode)) return wrong_type_failure(path, info.st_mode);
  file.size = static_cast<std::uint64_t>(info.st_size);
  return file;
}

Result<bool> begins_with(const std::string& path, std::string_view bytes) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return false;
  const auto file = open_regular_file(path);
  if (!file) return failure(file.error());
  std::string beginning(bytes.size(), '\0');
  const auto size = read_some(file->descriptor.number(), beginning.data(), beginning.size());
  return size == std::ssize(beginning) && beginning == bytes;
}

Result<std::string> read_whole(const RegularFile& file, const std::string& path, std::size_t most) {
  if (file.size > most) {
    std::string beginning(kSqliteBeginning.size(), '\0');
    const auto size = ::pread(file.descriptor.number(), beginning.data(), beginning.size(), 0);
    const bool is_sqlite = size == std::ssize(beginning) && beginning == kSqliteBeginning;
    return failure(FaultKind::bad_file, path + ":1:1",
                   fmt::format("{} {} bytes, expected {}at most {}",
                               is_sqlite ? "is an SQLite file, as records are, of" : "the file has", file.size,
                               is_sqlite ? "another file of " : "", most));
  }
  std::string text;
  const auto size = static_cast<std::size_t>(file.size);
  if (!read_up_to(file.descriptor.number(), text, size + 1)) return read_failure(path, std::strerror(errno));
  if (text.size() == size) return text;
  return read_failure(
      path, fmt::format("its size was {} bytes, but {} bytes were read; expected a file that does not change", size,
                        text.size() > size ? "more" : std::to_string(text.size())));
}

Result<std::string> read_text_file(const std::string& path, std::size_t most) {
  return open_regular_file(path).and_then([&](const RegularFile& file) { return read_whole(file, path, most); });
}

Result<std::optional<std::string>> read_text_file_if_any(const std::string& path, std::size_t most, Links links) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0 && errno == ENOENT) return std::nullopt;
  auto text =
      open_regular_file(path, links).and_then([&](const RegularFile& file) { return read_whole(file, path, most); });
  if (!text) return failure(std::move(text.error()));
  return std::move(*text);
}

namespace {

constexpr mode_t kModeForAll = 0644;
constexpr mode_t kModeForGroup = 0640;
constexpr mode_t kModeForOwner = 0600;
constexpr int kMaxAttempts = 100;  ///< attempts to find a free name
/// Number of bytes of the old name in the temporary name. A file name may have 255 bytes.
constexpr std::size_t kKeptNameBytes = 200;

/// A path split into its open folder and the name in it.
struct SplitPath {
  Descriptor folder;
  std::string name;
};

/// Opens the folder of a path. Fails with storage if it cannot be opened or the path names a folder.
Result<SplitPath> split_path(const std::string& path) {
  const std::filesystem::path whole(path);
  SplitPath split{.folder = Descriptor(::open(parent_folder(whole).c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)),
                  .name = whole.filename().string()};
  if (!split.folder.is_open())
    return failure(FaultKind::storage, path, std::string("cannot be written: ") + std::strerror(errno));
  if (split.name.empty() || split.name == "." || split.name == "..")
    return failure(FaultKind::storage, path, "cannot be written: is a folder");
  return split;
}

/// Returns an unpredictable name for a temporary file next to `name`.
std::string temporary_name(const std::string& name) {
  std::uint64_t drawn{};
  while (::getrandom(&drawn, sizeof drawn, 0) != sizeof drawn) {
  }
  return fmt::format("{}.{:016x}.part", name.substr(0, kKeptNameBytes), drawn);
}

/// Creates a temporary file, opens it for writing and sets `name`. On failure returns a closed descriptor and sets
/// errno.
Descriptor create_new_file(const SplitPath& split, std::string& name, mode_t mode) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  for (int i = 0; i < kMaxAttempts; ++i) {
    name = temporary_name(split.name);
    Descriptor file(::openat(split.folder.number(), name.c_str(), kFlags, mode));
    if (file.is_open() || errno != EEXIST) return file;
  }
  return {};
}

void sync_folder(const SplitPath& split) {
  const Descriptor folder(::openat(split.folder.number(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.is_open()) ::fsync(folder.number());
}

/// Blocks the signals of this thread for the lifetime of the object. A signal that ended the program meanwhile would
/// leave a temporary file.
class SignalBlock {
 public:
  SignalBlock() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~SignalBlock() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalBlock(const SignalBlock&) = delete;
  SignalBlock& operator=(const SignalBlock&) = delete;

 private:
  sigset_t before_{};
};

struct ReplaceOptions {
  mode_t mode{};
  bool ignores_umask{};
  Syncing syncing{};
};

/// Sets the mode of a new file regardless of the umask, but denies the group access if the umask does.
bool set_mode(int file, mode_t mode) {
  struct stat made {};
  if (::fstat(file, &made) != 0) return false;
  return ::fchmod(file, (made.st_mode & S_IRGRP) != 0 ? mode : mode & S_IRWXU) == 0;
}

/// Writes a temporary file and renames it. On failure, removes the temporary file and returns false with errno set.
bool write_and_rename(const SplitPath& split, std::string_view text, const ReplaceOptions& options) {
  const SignalBlock until_renamed;
  std::string name;
  const auto file = create_new_file(split, name, options.mode);
  if (!file.is_open()) return false;
  const bool done = (!options.ignores_umask || set_mode(file.number(), options.mode)) &&
                    write_all(file.number(), text) &&
                    (options.syncing == Syncing::not_awaited || ::fsync(file.number()) == 0) &&
                    ::renameat(split.folder.number(), name.c_str(), split.folder.number(), split.name.c_str()) == 0;
  if (done) return true;
  const int error = errno;
  ::unlinkat(split.folder.number(), name.c_str(), 0);
  errno = error;
  return false;
}

Result<void> replace_file(const std::string& path, const std::string& target, std::string_view text,
                          const ReplaceOptions& options) {
  const auto split = split_path(target);
  if (!split) return failure(split.error().kind, path, split.error().what);
  if (!write_and_rename(*split, text, options))
    return failure(FaultKind::storage, path, std::string("cannot be written: ") + std::strerror(errno));
  if (options.syncing == Syncing::awaited) sync_folder(*split);
  return {};
}

}  // namespace

Result<void> replace_text_file(const std::string& path, std::string_view text) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return failure(FaultKind::storage, path, "exists and is not a regular file; it is not replaced");
  const auto target = std::filesystem::weakly_canonical(path, error).string();
  return replace_file(path, target.empty() ? path : target, text,
                      {.mode = kModeForAll, .ignores_umask = false, .syncing = Syncing::awaited});
}

Result<void> replace_own_file(const std::string& path, std::string_view text, Syncing syncing, Readers readers) {
  const mode_t mode = readers == Readers::owner ? kModeForOwner : kModeForGroup;
  return replace_file(path, path, text, {.mode = mode, .ignores_umask = true, .syncing = syncing});
}

FileState read_file_state(const std::string& path) {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return {};
  return {.device = info.st_dev,
          .inode = info.st_ino,
          .changed_ns = std::int64_t{info.st_mtim.tv_sec} * kNanoseconds + info.st_mtim.tv_nsec,
          .size = info.st_size};
}

FileState read_file_identity(const std::string& path) {
  auto state = read_file_state(path);
  if (state.is_there()) state.changed_ns = state.size = 0;
  return state;
}

std::string parent_folder(const std::filesystem::path& path) {
  const auto folder = path.parent_path();
  return folder.empty() ? "." : folder.string();
}

std::vector<std::filesystem::path> list_folder(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    found.push_back(at->path());
  return found;
}

}  // namespace gyrotherm
