// SPDX-License-Identifier: Apache-2.0
/// Byte streams over TCP and over a serial port, also one whose adapter echoes.
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <memory>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/result.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

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

/// Opens `device` without waiting for a carrier, for this program alone (a lock that others respect, and the kernel's),
/// with `format`, which is read back. Reads and writes do not block. Fails with disconnected.
[[nodiscard]] Result<Descriptor> open_serial_port(const std::string& device, const SerialFormat& format);

/// Returns the link to `device` under /dev/serial/by-id, which remains when adapters are plugged in another order;
/// empty if there is none.
[[nodiscard]] std::string stable_name(const std::string& device);
/// Returns whether the number in the name of a device file depends on the order of plugging, as in /dev/ttyUSB0.
[[nodiscard]] bool has_unstable_name(const std::string& device);

struct SerialPortFound {
  std::string device;       ///< "/dev/ttyUSB0"
  std::string description;  ///< "FT232R USB UART - A50285BI", as the adapter says
  std::string serial;       ///< of a USB adapter, else empty
  std::string stable_name;  ///< the link under /dev/serial/by-id, which survives another order of plugging; or empty
  int vendor{}, product{};  ///< of a USB adapter, else 0
};
[[nodiscard]] std::vector<SerialPortFound> serial_ports();

/// Opens `device` at first use, for this program alone, and again after it was unplugged; a link is followed anew each
/// time. The settings are read back: a port that cannot do `format` is disconnected and says what it does instead.
/// What came before the opening is thrown away. After a second failure in a row the line rests 0.5 s, then longer, up
/// to 10 s; until then every use fails at once. A pseudo-terminal has no settings to make.
[[nodiscard]] std::unique_ptr<ByteStream> make_serial_stream(std::string device, const SerialFormat& format);

/// Returns `line` with an adapter that sends back what it is sent, as two-wire RS-485 adapters do whose receiver stays
/// on. Each write reads its echo and compares it with what was sent, so that reads return the bytes of others. Up to
/// eight stray bytes before the echo are ignored: nothing that precedes it can be an answer. A write fails as that of
/// `line`, with timeout if nothing comes back in 250 ms, or with corrupted if something else does; an answer may still
/// come then. `clock` must be that of `line` and outlive the stream; without one the steady clock counts.
[[nodiscard]] std::unique_ptr<ByteStream> make_echo_stream(std::unique_ptr<ByteStream> line,
                                                           const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
