#include "core/text_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace gyrotherm {
namespace {

enum class Disk { awaited, not_awaited };

/// Writes all; false with errno set.
bool write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// A new file with this text; false with errno set.
bool write_whole(const std::string& path, std::string_view text, Disk disk) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return false;
  const bool written = write_all(fd, text) && (disk == Disk::not_awaited || ::fsync(fd) == 0);
  const int error = errno;
  ::close(fd);
  errno = error;
  return written;
}

Result<void> replace(const std::string& path, std::string_view text, Disk disk) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return failure(FaultKind::storage, path, "is there and is no regular file; it is not replaced");
  const auto target = std::filesystem::weakly_canonical(path, error).string();  // a link stays a link
  const auto temporary = target + ".part";
  if (write_whole(temporary, text, disk) && std::rename(temporary.c_str(), target.c_str()) == 0) return {};
  const std::string why = std::strerror(errno);
  ::unlink(temporary.c_str());
  return failure(FaultKind::storage, path, "cannot be written: " + why);
}

}  // namespace

Result<std::string> read_text_file(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return failure(FaultKind::bad_file, path, "cannot be read: " + error.message());
  if (size > 256'000'000) return failure(FaultKind::bad_file, path, "larger than 256 MB");
  std::ifstream file(path, std::ios::binary);
  if (!file) return failure(FaultKind::bad_file, path, std::string("cannot be read: ") + std::strerror(errno));
  return std::string(std::istreambuf_iterator<char>(file), {});
}

Result<void> replace_text_file(const std::string& path, std::string_view text) {
  return replace(path, text, Disk::awaited);
}

Result<void> replace_passing_text_file(const std::string& path, std::string_view text) {
  return replace(path, text, Disk::not_awaited);
}

}  // namespace gyrotherm
