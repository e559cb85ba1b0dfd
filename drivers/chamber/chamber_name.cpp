#include "drivers/chamber/chamber_name.hpp"

#include <dirent.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/file.hpp"

namespace gyrotherm {
namespace {

constexpr int kManyCallers = 4096;       // the kernel takes as many of them as it allows
constexpr const char* kStream = "0001";  // of the type in proc(5), /proc/net/unix; each type has names of its own

/// unix(7): the first byte of an abstract name is zero. A place that is too long keeps its end, and a sum of it all.
std::string name_of(const std::string& place) {
  constexpr std::size_t kLongest = 70;
  const auto shown = place.size() <= kLongest
                         ? place
                         : fmt::format("{:016x}-{}", std::hash<std::string>()(place), place.substr(place.size() - 50));
  return "gyrotherm-chamber/" + shown;
}

struct Address {
  sockaddr_un text{};
  socklen_t size{};
};

Address address_of(const std::string& place) {
  Address address;
  const auto name = name_of(place);
  address.text.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.text.sun_path + 1);
  address.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return address;
}

const sockaddr* as_sockaddr(const Address& address) { return reinterpret_cast<const sockaddr*>(&address.text); }

Descriptor new_socket() { return Descriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)); }

/// The number of the socket that has the name; 0 if there is none.
std::uint64_t inode_of(const std::string& place) {
  std::ifstream sockets("/proc/net/unix");
  const auto name = "@" + name_of(place);
  for (std::string line; std::getline(sockets, line);) {
    std::istringstream fields(line);
    std::string skipped, type, state, path;
    std::uint64_t inode = 0;
    for (int i = 0; i < 4; ++i) fields >> skipped;
    if (fields >> type >> state >> inode >> path && path == name && type == kStream) return inode;
  }
  return 0;
}

bool has_open(const std::filesystem::path& process, const std::string& socket) {
  const auto held = entries_of(process / "fd");
  return std::any_of(held.begin(), held.end(), [&](const auto& descriptor) {
    std::error_code error;
    return std::filesystem::read_symlink(descriptor, error) == socket;
  });
}

/// Of one that has the name and does not answer who it is: as far as this user may look into other processes.
NameOwner owner_by_descriptors(std::uint64_t inode) {
  const auto socket = fmt::format("socket:[{}]", inode);
  for (const auto& process : entries_of("/proc")) {
    const auto number = process.filename().string();
    if (!std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; })) continue;
    struct stat found {};
    if (has_open(process, socket) && ::stat(process.c_str(), &found) == 0)
      return {.pid = std::stoll(number), .uid = found.st_uid};
  }
  return {};
}

}  // namespace

tl::expected<Descriptor, int> take_name(const std::string& place) {
  const auto address = address_of(place);
  auto socket = new_socket();
  if (!socket.is_open() || ::bind(socket.number(), as_sockaddr(address), address.size) != 0 ||
      ::listen(socket.number(), kManyCallers) != 0)
    return tl::unexpected(errno);
  return socket;
}

std::optional<NameOwner> owner_of_name(const std::string& place) {
  const auto address = address_of(place);
  const auto socket = new_socket();
  ucred owner{};
  socklen_t size = sizeof owner;
  if (socket.is_open() && ::connect(socket.number(), as_sockaddr(address), address.size) == 0 &&
      ::getsockopt(socket.number(), SOL_SOCKET, SO_PEERCRED, &owner, &size) == 0)
    return NameOwner{.pid = owner.pid, .uid = owner.uid};
  const auto inode = inode_of(place);
  return inode == 0 ? std::nullopt : std::optional(owner_by_descriptors(inode));
}

}  // namespace gyrotherm
