#include "sequencer/watchdog/notify_socket.hpp"

#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace gyrotherm {

std::optional<NotifySocket> NotifySocket::from_environment() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  return address && *address ? at(address) : std::nullopt;
}

std::optional<NotifySocket> NotifySocket::at(std::string address) {
  if (address.empty() || address.size() >= sizeof(sockaddr_un::sun_path)) return {};
  Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.is_open()) return {};
  return NotifySocket(std::move(socket), std::move(address));
}

void NotifySocket::tell(std::string_view state) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), to.sun_path);
  if (to.sun_path[0] == '@') to.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  ::sendto(socket_.number(), state.data(), state.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to), size);
}

}  // namespace gyrotherm
