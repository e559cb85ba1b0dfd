#include "drivers/chamber/chamber_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

namespace gyrotherm {
namespace {

constexpr mode_t kForAll = 0666;         ///< any user's program must be able to meet the lock
constexpr mode_t kForAllSticky = 01777;  ///< … and none may remove another's

std::string as_file_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.';
    name += plain ? std::string(1, c) : c == '/' ? "-" : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return name;
}

/// In the order of preference: all users of the machine should use the same.
std::vector<std::string> folders() {
  std::vector<std::string> all{"/run/lock/gyrotherm"};
  if (const char* own = std::getenv("XDG_RUNTIME_DIR"); own && *own == '/')
    all.push_back(std::string(own) + "/gyrotherm");
  all.push_back("/tmp/gyrotherm-lock");
  return all;
}

/// Makes the folder if it is not there; true for a folder, no link, in which others cannot remove a lock.
bool usable(const std::string& folder) {
  if (::mkdir(folder.c_str(), kForAllSticky) == 0) ::chmod(folder.c_str(), kForAllSticky);  // in spite of the umask
  struct stat found {};
  if (::lstat(folder.c_str(), &found) != 0 || !S_ISDIR(found.st_mode)) return false;
  const bool others_write = (found.st_mode & (S_IWGRP | S_IWOTH)) != 0;
  return !others_write || (found.st_mode & S_ISVTX) != 0;
}

/// The lock file, made if it is not there. Not by O_CREAT alone: in a sticky folder the kernel refuses that for another
/// user's file.
Descriptor opened(const std::string& path) {
  constexpr int kFlags = O_RDWR | O_CLOEXEC | O_NOFOLLOW;
  const int made = ::open(path.c_str(), kFlags | O_CREAT | O_EXCL, kForAll);
  if (made >= 0) ::fchmod(made, kForAll);
  return Descriptor(made >= 0 ? made : ::open(path.c_str(), kFlags));
}

std::string content(int file) {
  char text[4096];
  const auto size = ::pread(file, text, sizeof text, 0);
  return {text, static_cast<std::size_t>(size < 0 ? 0 : size)};
}

std::string value_of(const std::string& text, const std::string& key) {
  const auto at = text.find("\n" + key + ": ");
  if (at == std::string::npos) return "unknown";
  const auto from = at + key.size() + 3;
  return text.substr(from, text.find('\n', from) - from);
}

std::string holder_in_words(int file) {
  const auto text = content(file);
  return fmt::format("process {}, record {}", value_of(text, "pid"), value_of(text, "record"));
}

/// False if the file has been removed meanwhile: then the lock on it means nothing.
bool still_at(const std::string& path, int file) {
  struct stat named {
  }, held{};
  return ::stat(path.c_str(), &named) == 0 && ::fstat(file, &held) == 0 && named.st_ino == held.st_ino &&
         named.st_dev == held.st_dev;
}

void sign(int file, const std::string& record) {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  const auto text = fmt::format("gyrotherm-lock/1\npid: {}\nboot: {}\nrecord: {}\n", ::getpid(), boot, record);
  if (::ftruncate(file, 0) == 0) [[maybe_unused]]
    const auto written = ::pwrite(file, text.data(), text.size(), 0);
}

}  // namespace

std::string chamber_place(const Line& line, std::uint16_t usual_port, std::uint8_t unit) {
  if (const auto* tcp = std::get_if<TcpLine>(&line))
    return fmt::format("tcp-{}-{}-{}", as_file_name(tcp->host), tcp->port == 0 ? usual_port : tcp->port, unit);
  if (const auto* serial = std::get_if<SerialLine>(&line)) {
    std::error_code error;
    const auto device = std::filesystem::weakly_canonical(serial->device, error).string();
    return "serial" + as_file_name(error ? serial->device : device);
  }
  return as_file_name(text(line));
}

Result<ChamberLock> ChamberLock::take(const std::string& place, const std::string& record) {
  std::string why = "no folder for it can be used";
  for (const auto& folder : folders()) {
    if (!usable(folder)) continue;
    const auto path = folder + "/" + place + ".lock";
    for (int again = 0; again < 3; ++again) {
      auto file = opened(path);
      if (!file.is_open()) {
        why = fmt::format("{}: {}", path, std::strerror(errno));
        break;
      }
      if (::flock(file.number(), LOCK_EX | LOCK_NB) != 0)
        return failure(FaultKind::refused, "chamber " + place,
                       fmt::format("another program drives it: {}", holder_in_words(file.number())));
      if (!still_at(path, file.number())) continue;
      sign(file.number(), record);
      return ChamberLock(std::move(file));
    }
  }
  return failure(FaultKind::storage, "chamber " + place, "its lock cannot be made: " + why);
}

std::optional<std::string> ChamberLock::holder(const std::string& place) {
  for (const auto& folder : folders()) {
    const auto path = folder + "/" + place + ".lock";
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
    if (!file.is_open()) continue;
    if (::flock(file.number(), LOCK_SH | LOCK_NB) != 0) return holder_in_words(file.number());
  }
  return {};
}

}  // namespace gyrotherm
