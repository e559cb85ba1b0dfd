#include "app/guard/small_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

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

Result<std::optional<std::string>> read_small_file(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open() && errno == ENOENT) return std::nullopt;
  std::string text;
  char piece[4096];
  ssize_t size = file.is_open() ? 1 : -1;
  while (size > 0 && text.size() <= kLargest)
    if (size = ::read(file.number(), piece, sizeof piece); size > 0) text.append(piece, static_cast<std::size_t>(size));
  if (size < 0) return failure(FaultKind::bad_file, path, std::string("cannot be read: ") + std::strerror(errno));
  if (text.size() > kLargest) return failure(FaultKind::bad_file, path, "larger than 4 MB");
  return text;
}

}  // namespace gyrotherm
