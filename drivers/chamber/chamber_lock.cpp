// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/chamber_lock.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <linux/sock_diag.h>
#include <linux/unix_diag.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/abstract_socket.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm::drivers {
namespace {

/// Splits a line of passwd(5) or group(5) at its colons.
std::vector<std::string> split_fields(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ':');) fields.push_back(field);
  return fields;
}

bool has_member(const std::string& members, const std::string& user) {
  std::istringstream stream(members);
  for (std::string member; std::getline(stream, member, ',');)
    if (member == user) return true;
  return false;
}

/// Returns the number of the user's primary group, or an empty string if /etc/passwd does not list the user.
std::string find_primary_group(std::int64_t uid) {
  std::ifstream users("/etc/passwd");
  for (std::string line; std::getline(users, line);)
    if (const auto fields = split_fields(line); fields.size() > 3 && fields[2] == std::to_string(uid)) return fields[3];
  return {};
}

bool is_member(std::int64_t uid) {
  const auto own = find_primary_group(uid);
  if (own.empty()) return false;
  const auto user = user_name(uid);
  std::ifstream groups("/etc/group");
  for (std::string line; std::getline(groups, line);) {
    const auto fields = split_fields(line);
    if (fields.size() < 3 || std::ranges::count(kChamberGroups, fields[0]) == 0) continue;
    if (fields[2] == own || (fields.size() > 3 && has_member(fields[3], user))) return true;
  }
  return false;
}

struct SocketQuery {
  nlmsghdr header{};
  unix_diag_req request{};
};

/// Reads the user from an answer of the kernel. Returns nothing if the answer is an error or has no user.
std::optional<std::int64_t> find_user(const char* answer, std::size_t size) {
  nlmsghdr header{};
  if (size < sizeof header) return {};
  std::memcpy(&header, answer, sizeof header);
  if (header.nlmsg_type != SOCK_DIAG_BY_FAMILY) return {};
  const auto end = std::min<std::size_t>(size, header.nlmsg_len);
  for (std::size_t at = NLMSG_LENGTH(sizeof(unix_diag_msg)); at + sizeof(rtattr) <= end;) {
    rtattr attribute{};
    std::memcpy(&attribute, answer + at, sizeof attribute);
    if (attribute.rta_len < sizeof attribute || at + attribute.rta_len > end) return {};
    std::uint32_t uid{};
    if (attribute.rta_type == UNIX_DIAG_UID && attribute.rta_len >= RTA_LENGTH(sizeof uid)) {
      std::memcpy(&uid, answer + at + RTA_LENGTH(0), sizeof uid);
      return uid;
    }
    at += RTA_ALIGN(attribute.rta_len);
  }
  return {};
}

}  // namespace

bool may_drive_chambers(std::int64_t uid) {
  return uid <= 0 || uid == static_cast<std::int64_t>(::geteuid()) || is_member(uid);
}

std::optional<std::int64_t> find_socket_user(std::uint32_t inode) {
  constexpr auto kKernelTimeout = std::chrono::milliseconds(200);
  const Descriptor socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_SOCK_DIAG));
  SocketQuery query;
  query.header.nlmsg_len = sizeof query;
  query.header.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  query.header.nlmsg_flags = NLM_F_REQUEST;
  query.request.sdiag_family = AF_UNIX;
  query.request.udiag_states = ~0U;
  query.request.udiag_ino = inode;
  query.request.udiag_show = UDIAG_SHOW_UID;
  query.request.udiag_cookie[0] = query.request.udiag_cookie[1] = ~0U;
  if (!socket.is_open() || ::send(socket.number(), &query, sizeof query, 0) < 0) return {};
  if (!wait_until_ready(socket.number(), POLLIN, Deadline(kKernelTimeout))) return {};
  std::array<char, 1024> answer{};
  const auto size = ::recv(socket.number(), answer.data(), answer.size(), MSG_DONTWAIT);
  return size < 0 ? std::nullopt : find_user(answer.data(), static_cast<std::size_t>(size));
}

namespace {

// The kernel limits the queue to its own maximum.
constexpr int kBacklog = 4096;
// Socket type in /proc/net/unix (proc(5)); each type has its own names.
constexpr const char* kStreamType = "0001";

/// Returns the abstract name of a chamber, without its leading zero byte (unix(7)). A long identifier is replaced by
/// its hash and its end.
std::string socket_name(const std::string& place) {
  constexpr std::size_t kMaxPlainLength = 70;
  return "gyrotherm-chamber/" + shorten_for_name(place, kMaxPlainLength);
}

constexpr char kSpareMark = '#';  ///< "NAME#5f0c…" is a spare name

/// Returns a spare name. It is random, so no process can have bound it in advance.
std::string spare_name(const std::string& place) {
  std::random_device device;
  return fmt::format("{}{}{:08x}{:08x}", socket_name(place), kSpareMark, device(), device());
}

/// Name of a bound socket in the abstract namespace, and the socket's inode.
struct NamedSocket {
  std::string name;
  std::uint64_t inode{};
};

/// Returns the sockets with the chamber's name or a spare name. Each name is listed once, although accepted connections
/// have the same name and user.
std::vector<NamedSocket> find_sockets(const std::string& place) {
  std::ifstream sockets("/proc/net/unix");
  const auto own = "@" + socket_name(place);
  std::vector<NamedSocket> found;
  for (std::string line; std::getline(sockets, line);) {
    std::istringstream fields(line);
    std::string skipped, type, state, path;
    std::uint64_t inode = 0;
    for (int i = 0; i < 4; ++i) fields >> skipped;
    if (!(fields >> type >> state >> inode >> path) || type != kStreamType || inode == 0) continue;
    if (path != own && !path.starts_with(own + kSpareMark)) continue;
    const auto name = path.substr(1);
    if (std::ranges::find(found, name, &NamedSocket::name) == found.end()) found.push_back({name, inode});
  }
  return found;
}

bool has_open_socket(const std::filesystem::path& process, const std::string& socket) {
  const auto held = list_folder(process / "fd");
  return std::any_of(held.begin(), held.end(), [&](const auto& descriptor) {
    std::error_code error;
    return std::filesystem::read_symlink(descriptor, error) == socket;
  });
}

/// Finds the process that holds a socket, by the open files of all processes. The result is unknown if this user may
/// not inspect the process.
NameOwner find_owner_by_descriptors(std::uint64_t inode) {
  const auto socket = fmt::format("socket:[{}]", inode);
  for (const auto& process : list_folder("/proc")) {
    const auto number = process.filename().string();
    if (!std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; })) continue;
    struct stat found {};
    if (has_open_socket(process, socket) && ::stat(process.c_str(), &found) == 0)
      return {.pid = std::stoll(number), .uid = found.st_uid};
  }
  return {};
}

constexpr mode_t kFolderMode = 0755;
/// Not readable for other users, because a user who can open the file can lock it.
constexpr mode_t kFileMode = 0600;
constexpr mode_t kWritableByOthers = S_IWGRP | S_IWOTH;

std::string as_file_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.';
    name += plain ? std::string(1, c) : c == '/' ? "-" : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return name;
}

/// Returns the candidate folders for the lock file, in order of preference. None is on a disk, because a disk may hang.
/// Every user may write to the parent of the last folder, so it is not used if another user has created it.
std::vector<std::string> candidate_folders() {
  std::vector<std::string> all{"/run/gyrotherm"};
  if (const char* own = std::getenv("XDG_RUNTIME_DIR"); own && *own == '/')
    all.push_back(std::string(own) + "/gyrotherm");
  all.push_back(fmt::format("/run/lock/gyrotherm-{}", ::geteuid()));
  return all;
}

bool is_writable_by_this_user_only(const struct stat& found) {
  return found.st_uid == ::geteuid() && (found.st_mode & kWritableByOthers) == 0;
}

/// Opens a folder that this user owns and that no other user may write. Creates it if necessary. Does not follow a
/// link.
Descriptor open_own_folder(const std::string& path) {
  ::mkdir(path.c_str(), kFolderMode);
  Descriptor folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat found {};
  if (!folder.is_open() || ::fstat(folder.number(), &found) != 0 || !is_writable_by_this_user_only(found)) return {};
  return folder;
}

/// Opens the lock file of a chamber. Returns a closed descriptor if no folder is usable.
Descriptor open_lock_file(const std::string& place) {
  for (const auto& path : candidate_folders()) {
    const auto folder = open_own_folder(path);
    if (!folder.is_open()) continue;
    Descriptor file(::openat(folder.number(), (place + ".lock").c_str(),
                             O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, kFileMode));
    struct stat found {};
    if (file.is_open() && ::fstat(file.number(), &found) == 0 && S_ISREG(found.st_mode) &&
        is_writable_by_this_user_only(found) && ::fchmod(file.number(), kFileMode) == 0)
      return file;
  }
  return {};
}

std::string read_file(int file) {
  char text[4096];
  const auto size = ::pread(file, text, sizeof text, 0);
  return {text, static_cast<std::size_t>(size < 0 ? 0 : size)};
}

std::string find_value(const std::string& text, const std::string& key) {
  const auto at = text.find("\n" + key + ": ");
  if (at == std::string::npos) return "unknown";
  const auto from = at + key.size() + 3;
  return text.substr(from, text.find('\n', from) - from);
}

void write_signature(int file, const std::string& record) {
  const auto text = fmt::format("gyrotherm-lock/1\npid: {}\nrecord: {}\n", ::getpid(), record);
  if (::ftruncate(file, 0) == 0) [[maybe_unused]]
    const auto written = ::pwrite(file, text.data(), text.size(), 0);
}

/// Returns ", record PATH" for a message if process `pid` signed the lock file, otherwise an empty text.
std::string record_suffix(const std::string& signature, std::int64_t pid) {
  return find_value(signature, "pid") == std::to_string(pid) ? ", record " + find_value(signature, "record") : "";
}

ChamberHolder describe_holder(ChamberHolder holder, const std::string& signature) {
  holder.words = holder.pid == 0 ? "an unidentified process"
                                 : fmt::format("process {} of {}{}", holder.pid, describe_user(holder.uid),
                                               record_suffix(signature, holder.pid));
  return holder;
}

/// Returns the process that signed the lock file, or nothing if no program of this user holds the file.
std::optional<ChamberHolder> read_lock_holder(int file) {
  if (::flock(file, LOCK_SH | LOCK_NB) == 0) {
    ::flock(file, LOCK_UN);
    return {};
  }
  const auto signature = read_file(file);
  return describe_holder({.pid = std::atoll(find_value(signature, "pid").c_str()), .uid = ::geteuid(), .words = {}},
                         signature);
}

tl::expected<Descriptor, int> bind_name(const std::string& name) {
  const auto address = make_abstract_address(name);
  auto socket = open_stream_socket();
  if (!socket.is_open() || ::bind(socket.number(), address.pointer(), address.size) != 0 ||
      ::listen(socket.number(), kBacklog) != 0)
    return tl::unexpected(errno);
  return socket;
}

/// Returns the process and user of a named socket. If the queue of the socket has space, both are known after
/// connecting to it. Otherwise sock_diag reports the user, and the process is found by its open files.
NameOwner find_socket_owner(const NamedSocket& named) {
  const auto address = make_abstract_address(named.name);
  const auto socket = open_stream_socket();
  if (socket.is_open() && ::connect(socket.number(), address.pointer(), address.size) == 0)
    if (const auto owner = read_peer(socket.number())) return {.pid = owner->pid, .uid = owner->uid};
  auto found = find_owner_by_descriptors(named.inode);
  if (const auto uid = find_socket_user(static_cast<std::uint32_t>(named.inode))) found.uid = *uid;
  return found;
}

std::uint64_t socket_inode(const Descriptor& socket) {
  struct stat found {};
  return socket.is_open() && ::fstat(socket.number(), &found) == 0 ? found.st_ino : 0;
}

/// Processes that hold a name of the chamber.
struct Holders {
  std::optional<ChamberHolder> permitted{};  ///< first holder with a permitted user
  std::vector<ChamberHolder> unauthorised_holders{};
};

/// Examines every socket with a name of the chamber, except the one with inode `own`.
Holders find_holders(const std::string& place, const std::string& signature, std::uint64_t own = 0) {
  Holders holders;
  for (const auto& named : find_sockets(place)) {
    if (named.inode == own) continue;
    const auto owner = find_socket_owner(named);
    auto holder = describe_holder({.pid = owner.pid, .uid = owner.uid, .words = {}}, signature);
    if (!may_drive_chambers(owner.uid))
      holders.unauthorised_holders.push_back(std::move(holder));
    else if (!holders.permitted)
      holders.permitted = std::move(holder);
  }
  return holders;
}

tl::unexpected<Fault> in_use_fault(const std::string& place, const ChamberHolder& holder) {
  return failure(FaultKind::refused, "chamber " + place, "driven by another program: " + holder.words);
}

}  // namespace

tl::expected<Descriptor, int> bind_chamber_name(const std::string& place) { return bind_name(socket_name(place)); }

std::optional<NameOwner> find_name_owner(const std::string& place) {
  const auto all = find_sockets(place);
  const auto own = std::ranges::find(all, socket_name(place), &NamedSocket::name);
  return own == all.end() ? std::nullopt : std::optional(find_socket_owner(*own));
}

std::string chamber_lock_name(const Line& line, std::uint16_t usual_port, std::uint8_t unit) {
  if (const auto* tcp = std::get_if<TcpLine>(&line)) {
    const auto host = is_local_address(tcp->host) ? std::string("this.machine") : as_file_name(tcp->host);
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
  auto name = bind_chamber_name(place);
  if (!name && name.error() == EADDRINUSE) name = bind_name(spare_name(place));
  auto file = open_lock_file(place);
  auto holders =
      find_holders(place, file.is_open() ? read_file(file.number()) : std::string(), name ? socket_inode(*name) : 0);
  if (holders.permitted) return in_use_fault(place, *holders.permitted);
  if (!name && !file.is_open())
    return failure(FaultKind::storage, "chamber " + place,
                   fmt::format("cannot create the lock: {}", std::strerror(name.error())));
  if (file.is_open()) {
    if (::flock(file.number(), LOCK_EX | LOCK_NB) != 0)
      return in_use_fault(place, read_lock_holder(file.number()).value_or(describe_holder({}, {})));
    write_signature(file.number(), record);
  }
  ChamberLock lock(name ? std::move(*name) : Descriptor(), std::move(file));
  lock.unauthorised_holders_ = std::move(holders.unauthorised_holders);
  return lock;
}

std::optional<ChamberHolder> ChamberLock::holder(const std::string& place) {
  const auto file = open_lock_file(place);
  auto holders = find_holders(place, file.is_open() ? read_file(file.number()) : std::string());
  if (holders.permitted) return std::move(holders.permitted);
  return file.is_open() ? read_lock_holder(file.number()) : std::nullopt;
}

void ChamberLock::close_callers() const {
  constexpr int kMostAtOnce = 256;
  for (int i = 0; i < kMostAtOnce && name_.is_open(); ++i) {
    const Descriptor caller(::accept4(name_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!caller.is_open()) return;
  }
}

}  // namespace gyrotherm::drivers
