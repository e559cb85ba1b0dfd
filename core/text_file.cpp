#include "core/text_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace gyrotherm {
namespace {

tl::unexpected<Fault> unreadable(const std::string& path, const std::string& why) {
  return failure(FaultKind::bad_file, path, "cannot be read: " + why);
}

const char* what_it_is(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  if (S_ISLNK(mode)) return "a link";
  return "a device";
}

tl::unexpected<Fault> not_regular(const std::string& path, mode_t mode) {
  return failure(FaultKind::bad_file, path, fmt::format("is {}, expected a regular file", what_it_is(mode)));
}

/// Reads until `size` bytes are there or the file ends; false with errno set.
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

Result<RegularFile> open_regular_file(const std::string& path, Links links) {
  const bool follows = links == Links::followed;
  struct stat facts {};
  // Looked at before it is opened, for opening some devices does something to them.
  if (::fstatat(AT_FDCWD, path.c_str(), &facts, follows ? 0 : AT_SYMLINK_NOFOLLOW) != 0)
    return unreadable(path, std::strerror(errno));
  if (!S_ISREG(facts.st_mode)) return not_regular(path, facts.st_mode);
  const int flags = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | (follows ? 0 : O_NOFOLLOW);
  RegularFile file{.descriptor = Descriptor(::open(path.c_str(), flags))};
  if (!file.descriptor.is_open() || ::fstat(file.descriptor.number(), &facts) != 0)
    return unreadable(path, std::strerror(errno));
  if (!S_ISREG(facts.st_mode)) return not_regular(path, facts.st_mode);
  file.size = static_cast<std::uint64_t>(facts.st_size);
  return file;
}

Result<std::string> read_whole(const RegularFile& file, const std::string& path, std::size_t most) {
  if (file.size > most)
    return failure(FaultKind::bad_file, path + ":1:1",
                   fmt::format("the file has {} bytes, expected at most {}", file.size, most));
  std::string text;
  const auto size = static_cast<std::size_t>(file.size);
  if (!read_up_to(file.descriptor.number(), text, size + 1)) return unreadable(path, std::strerror(errno));
  if (text.size() == size) return text;
  return unreadable(path, fmt::format("it said that it has {} bytes and gives {}; expected a file that lies still",
                                      size, text.size() > size ? "more" : std::to_string(text.size())));
}

Result<std::string> read_text_file(const std::string& path, std::size_t most) {
  return open_regular_file(path).and_then([&](const RegularFile& file) { return read_whole(file, path, most); });
}

Result<std::optional<std::string>> read_text_file_if_any(const std::string& path, std::size_t most, Links links) {
  struct stat facts {};
  if (::lstat(path.c_str(), &facts) != 0 && errno == ENOENT) return std::nullopt;
  auto text =
      open_regular_file(path, links).and_then([&](const RegularFile& file) { return read_whole(file, path, most); });
  if (!text) return failure(std::move(text.error()));
  return std::move(*text);
}

}  // namespace gyrotherm
