// SPDX-License-Identifier: Apache-2.0
#include "core/abstract_socket.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace gyrotherm {

AbstractAddress make_abstract_address(std::string_view name) {
  AbstractAddress address;
  address.text.sun_family = AF_UNIX;
  const auto length = std::min(name.size(), sizeof address.text.sun_path - 1);
  std::copy_n(name.begin(), length, address.text.sun_path + 1);
  address.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  return address;
}

std::string shorten_for_name(const std::string& text, std::size_t longest) {
  constexpr std::size_t kHashLength = 20;  // enough for 16 digits and a dash
  if (text.size() <= longest) return text;
  return fmt::format("{:016x}-{}", std::hash<std::string>()(text), text.substr(text.size() - (longest - kHashLength)));
}

Descriptor open_stream_socket() { return Descriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)); }

std::optional<ucred> read_peer(int socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return {};
  return peer;
}

}  // namespace gyrotherm
