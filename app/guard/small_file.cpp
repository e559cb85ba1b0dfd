#include "app/guard/small_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/user_name.hpp"
#include "drivers/line/descriptor.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kLargest = 4'000'000;
constexpr mode_t kForTheGroup = 0640;

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(file, text.data(), text.size());
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return ::fsync(file) == 0;
}

bool write_whole(const std::string& path, std::string_view text) {
  ::unlink(path.c_str());  // what a crash left; never through a link that somebody put there
  const Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, kForTheGroup));
  return file.is_open() && write_all(file.number(), text);
}

void sync_folder_of(const std::string& path) {
  const auto parent = std::filesystem::path(path).parent_path().string();
  const Descriptor folder(::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.is_open()) ::fsync(folder.number());
}

}  // namespace

Result<void> put_small_file(const std::string& path, std::string_view text) {
  const auto temporary = path + ".part";
  if (!write_whole(temporary, text) || std::rename(temporary.c_str(), path.c_str()) != 0) {
    const std::string why = std::strerror(errno);
    ::unlink(temporary.c_str());
    return failure(FaultKind::storage, path, "cannot be written: " + why);
  }
  sync_folder_of(path);
  return {};
}

namespace {

/// Why a file that is open is not one to be read; empty: it is. `own`: nobody else may have written it.
std::string objection(int file, bool own) {
  struct stat found {};
  if (::fstat(file, &found) != 0) return std::string("cannot be read: ") + std::strerror(errno);
  if (!S_ISREG(found.st_mode)) return "is no regular file";
  if (!own) return {};
  if (found.st_uid != ::geteuid() && found.st_uid != 0)
    return "belongs to " + user_in_words(found.st_uid) + ", who is neither root nor this user";
  return (found.st_mode & (S_IWGRP | S_IWOTH)) == 0 ? "" : "may be written by others than its owner";
}

Result<std::optional<std::string>> read_file(const std::string& path, bool own) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!file.is_open() && errno == ENOENT) return std::nullopt;
  if (file.is_open())
    if (auto why = objection(file.number(), own); !why.empty())
      return failure(FaultKind::bad_file, path, std::move(why));
  std::string text;
  char piece[4096];
  ssize_t size = file.is_open() ? 1 : -1;
  while (size > 0 && text.size() <= kLargest)
    if (size = ::read(file.number(), piece, sizeof piece); size > 0) text.append(piece, static_cast<std::size_t>(size));
  if (size < 0) return failure(FaultKind::bad_file, path, std::string("cannot be read: ") + std::strerror(errno));
  if (text.size() > kLargest) return failure(FaultKind::bad_file, path, "larger than 4 MB");
  return text;
}

}  // namespace

Result<std::optional<std::string>> read_small_file(const std::string& path) { return read_file(path, false); }

Result<std::optional<std::string>> read_own_small_file(const std::string& path) { return read_file(path, true); }

}  // namespace gyrotherm
