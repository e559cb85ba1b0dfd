#include "drivers/chamber/chamber_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include "core/process.hpp"
#include "drivers/chamber/chamber_name.hpp"
#include "drivers/line/own_address.hpp"

namespace gyrotherm {
namespace {

constexpr mode_t kOwnFolder = 0755;
constexpr mode_t kOwnFile = 0600;  ///< whoever can open it at all can lock it
constexpr mode_t kWritableByOthers = S_IWGRP | S_IWOTH;

std::string as_file_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.';
    name += plain ? std::string(1, c) : c == '/' ? "-" : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return name;
}

/// In the order of preference, none of them on a disk, which may hang. The last one lies where anybody may make a
/// folder of that name first; then it is not the user's own, and is not used.
std::vector<std::string> folders() {
  std::vector<std::string> all{"/run/gyrotherm"};
  if (const char* own = std::getenv("XDG_RUNTIME_DIR"); own && *own == '/')
    all.push_back(std::string(own) + "/gyrotherm");
  all.push_back(fmt::format("/run/lock/gyrotherm-{}", ::geteuid()));
  return all;
}

bool is_own(const struct stat& found) {
  return found.st_uid == ::geteuid() && (found.st_mode & kWritableByOthers) == 0;
}

/// An open folder that is the user's own and nobody else may write; made if it is not there. Through no link.
Descriptor own_folder(const std::string& path) {
  ::mkdir(path.c_str(), kOwnFolder);
  Descriptor folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat found {};
  if (!folder.is_open() || ::fstat(folder.number(), &found) != 0 || !is_own(found)) return {};
  return folder;
}

/// The lock file of that place, open; none where no folder can be used.
Descriptor lock_file(const std::string& place) {
  for (const auto& path : folders()) {
    const auto folder = own_folder(path);
    if (!folder.is_open()) continue;
    Descriptor file(::openat(folder.number(), (place + ".lock").c_str(),
                             O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, kOwnFile));
    struct stat found {};
    if (file.is_open() && ::fstat(file.number(), &found) == 0 && S_ISREG(found.st_mode) && is_own(found) &&
        ::fchmod(file.number(), kOwnFile) == 0)
      return file;
  }
  return {};
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

void sign(int file, const std::string& record) {
  const auto text = fmt::format("gyrotherm-lock/1\npid: {}\nrecord: {}\n", ::getpid(), record);
  if (::ftruncate(file, 0) == 0) [[maybe_unused]]
    const auto written = ::pwrite(file, text.data(), text.size(), 0);
}

/// Of the process that signed the lock file, its record; where another one did, nothing.
std::string record_of(const std::string& signature, std::int64_t pid) {
  return value_of(signature, "pid") == std::to_string(pid) ? ", record " + value_of(signature, "record") : "";
}

ChamberHolder in_words(ChamberHolder holder, const std::string& signature) {
  holder.words = holder.pid == 0 ? "a process that does not say who it is"
                                 : fmt::format("process {} of {}{}", holder.pid, user_in_words(holder.uid),
                                               record_of(signature, holder.pid));
  return holder;
}

/// Of the lock file, if a program of this user holds it.
std::optional<ChamberHolder> holder_of(int file) {
  if (::flock(file, LOCK_SH | LOCK_NB) == 0) {
    ::flock(file, LOCK_UN);
    return {};
  }
  const auto signature = content(file);
  return in_words({.pid = std::atoll(value_of(signature, "pid").c_str()), .uid = ::geteuid(), .words = {}}, signature);
}

tl::unexpected<Fault> driven_by(const std::string& place, const ChamberHolder& holder) {
  return failure(FaultKind::refused, "chamber " + place, "another program drives it: " + holder.words);
}

}  // namespace

std::string chamber_place(const Line& line, std::uint16_t usual_port, std::uint8_t unit) {
  if (const auto* tcp = std::get_if<TcpLine>(&line)) {
    const auto host = is_own_address(tcp->host) ? std::string("this.machine") : as_file_name(tcp->host);
    return fmt::format("tcp-{}-{}-{}", host, tcp->port == 0 ? usual_port : tcp->port, unit);
  }
  if (const auto* serial = std::get_if<SerialLine>(&line)) {
    std::error_code error;
    const auto device = std::filesystem::weakly_canonical(serial->device, error).string();
    return "serial" + as_file_name(error ? serial->device : device);
  }
  return as_file_name(text(line));
}

Result<ChamberLock> ChamberLock::take(const std::string& place, const std::string& record) {
  auto name = take_name(place);
  if (!name && name.error() == EADDRINUSE) return driven_by(place, holder(place).value_or(in_words({}, {})));
  auto file = lock_file(place);
  if (!name && !file.is_open())
    return failure(FaultKind::storage, "chamber " + place,
                   fmt::format("its lock cannot be made: {}", std::strerror(name.error())));
  if (file.is_open()) {
    if (::flock(file.number(), LOCK_EX | LOCK_NB) != 0)
      return driven_by(place, holder_of(file.number()).value_or(in_words({}, {})));
    sign(file.number(), record);
  }
  return ChamberLock(name ? std::move(*name) : Descriptor(), std::move(file));
}

std::optional<ChamberHolder> ChamberLock::holder(const std::string& place) {
  const auto file = lock_file(place);
  if (const auto owner = owner_of_name(place))
    return in_words({.pid = owner->pid, .uid = owner->uid, .words = {}},
                    file.is_open() ? content(file.number()) : std::string());
  return file.is_open() ? holder_of(file.number()) : std::nullopt;
}

void ChamberLock::dismiss_callers() const {
  constexpr int kMostAtOnce = 256;
  for (int i = 0; i < kMostAtOnce && name_.is_open(); ++i) {
    const Descriptor caller(::accept4(name_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!caller.is_open()) return;
  }
}

}  // namespace gyrotherm
