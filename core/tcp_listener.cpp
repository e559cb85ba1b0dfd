// SPDX-License-Identifier: Apache-2.0
#include "core/tcp_listener.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>
#include <system_error>

namespace gyrotherm {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

/// Returns the addresses to bind, or null with errno set if there is none.
Addresses resolve_addresses(const std::string& address, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  errno = 0;
  const int code = ::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (code != 0 && code != EAI_SYSTEM) errno = EADDRNOTAVAIL;
  return {code == 0 ? found : nullptr, ::freeaddrinfo};
}

}  // namespace

Result<Descriptor> listen_on_tcp(const std::string& address, std::uint16_t port, int backlog) {
  const auto addresses = resolve_addresses(address, port);
  for (const auto* one = addresses.get(); one != nullptr; one = one->ai_next) {
    Descriptor listener(::socket(one->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!listener.is_open()) continue;
    const int on = 1;
    ::setsockopt(listener.number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (::bind(listener.number(), one->ai_addr, one->ai_addrlen) == 0 && ::listen(listener.number(), backlog) == 0)
      return listener;
  }
  return failure(FaultKind::disconnected, fmt::format("{}:{}", address, port),
                 "cannot listen: " + std::generic_category().message(errno));
}

std::uint16_t listening_port(const Descriptor& listener) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  ::getsockname(listener.number(), reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

Descriptor accept_connection(const Descriptor& listener) {
  return Descriptor(::accept4(listener.number(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
}

}  // namespace gyrotherm
