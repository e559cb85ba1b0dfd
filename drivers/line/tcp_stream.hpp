/// A byte stream over TCP.
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <memory>

#include "drivers/line/line_address.hpp"

namespace gyrotherm {

/// The peer is asked every second once it has been quiet for 5 s, and the line breaks after 5 s without an
/// acknowledgement, whether something is sent or nothing. Small writes go out at once.
inline void guard_against_half_open(int socket) {
  constexpr int kGiveUpUnacknowledgedMs = 5000;
  const auto set = [socket](int level, int option, int value) {
    ::setsockopt(socket, level, option, &value, sizeof value);
  };
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 5);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 1);
  set(IPPROTO_TCP, TCP_KEEPCNT, 5);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, kGiveUpUnacknowledgedMs);
  set(IPPROTO_TCP, TCP_NODELAY, 1);
}

/// Connects at first use, and again after the line broke; a connection has `connect_within` to come about.
/// After a second failure in a row the line rests 0.5 s, then longer, up to 10 s; until then every use fails at once.
[[nodiscard]] std::unique_ptr<ByteStream> make_tcp_stream(const TcpLine& line, Duration connect_within);

}  // namespace gyrotherm
