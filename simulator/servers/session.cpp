// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/session.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "core/tcp_listener.hpp"
#include "core/text.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr std::size_t kLongestCommand = 64;

}  // namespace

bool TextSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  for (const auto byte : bytes) {
    const char character = static_cast<char>(byte);
    if (character != end_) {
      if (line_.size() < kLongestCommand)
        line_.push_back(character);
      else
        line_too_long_ = true;
      continue;
    }
    const auto text = line_too_long_ ? std::string{} : answer(trimmed(line_, kBlanks));
    const auto answered = std::as_bytes(std::span(text));
    reply.insert(reply.end(), answered.begin(), answered.end());
    line_.clear();
    line_too_long_ = false;
  }
  return true;
}

namespace {

constexpr int kBacklog = 128;

tl::unexpected<Fault> pty_fault() {
  return failure(FaultKind::disconnected, "virtual instrument",
                 "cannot open a pseudo-terminal: " + std::generic_category().message(errno));
}

}  // namespace

Result<Descriptor> listen_on_loopback(std::uint16_t port) {
  auto listener = listen_on_tcp("127.0.0.1", port, kBacklog);
  if (!listener) listener.error().where = "virtual instrument " + listener.error().where;
  return listener;
}

Descriptor accept_client(const Descriptor& listener) {
  auto client = accept_connection(listener);
  const int yes = 1;
  if (client.is_open()) ::setsockopt(client.number(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  return client;
}

bool send_now(const Descriptor& client, std::span<const std::byte> bytes) {
  const auto sent = ::send(client.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return sent >= 0 && static_cast<std::size_t>(sent) == bytes.size();
}

Result<Pty> open_pty() {
  constexpr std::size_t kLongestPath = 64;
  Pty pty{.ours = Descriptor(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)),
          .theirs = Descriptor(),
          .path = {}};
  std::array<char, kLongestPath> path{};
  if (!pty.ours.is_open() || ::grantpt(pty.ours.number()) != 0 || ::unlockpt(pty.ours.number()) != 0 ||
      ::ptsname_r(pty.ours.number(), path.data(), path.size()) != 0)
    return pty_fault();
  pty.path = path.data();
  pty.theirs = Descriptor(::open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!pty.theirs.is_open() || ::tcgetattr(pty.theirs.number(), &settings) != 0) return pty_fault();
  ::cfmakeraw(&settings);
  if (::tcsetattr(pty.theirs.number(), TCSANOW, &settings) != 0) return pty_fault();
  return pty;
}

void send_now(const Pty& pty, std::span<const std::byte> bytes) {
  // A client that locked the line exclusively may have closed it.
  ::ioctl(pty.theirs.number(), TIOCNXCL);
  const auto written = ::write(pty.ours.number(), bytes.data(), bytes.size());
  if (written == static_cast<ssize_t>(bytes.size())) return;
  ::tcflush(pty.theirs.number(), TCIFLUSH);
  [[maybe_unused]] const auto again = ::write(pty.ours.number(), bytes.data(), bytes.size());
}

}  // namespace gyrotherm::simulator
