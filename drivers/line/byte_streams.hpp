// SPDX-License-Identifier: Apache-2.0
/// Byte streams over TCP and serial ports, including adapters that echo.
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

/// Configures a socket to detect a dead peer: after 5 s of silence it sends a keep-alive probe every second, and the
/// connection breaks after 5 s without an acknowledgement of data or probes. Also sends small writes immediately.
inline void enable_dead_peer_detection(int socket) {
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

/// Returns a stream that connects at first use and again after the connection broke. Connecting may take up to
/// `connect_within`. After the second consecutive failure, calls fail immediately for 0.5 s, then for longer periods up
/// to 10 s.
[[nodiscard]] std::unique_ptr<ByteStream> make_tcp_stream(const TcpLine& line, Duration connect_within);

/// Opens `device` without waiting for a carrier, sets `format` and reads it back. Excludes other processes by an
/// advisory lock and TIOCEXCL. Reads and writes do not block. Fails with disconnected.
[[nodiscard]] Result<Descriptor> open_serial_port(const std::string& device, const SerialFormat& format);

/// Returns the link to `device` under /dev/serial/by-id, whose name does not depend on the order in which adapters are
/// plugged in, or an empty text if there is none.
[[nodiscard]] std::string stable_name(const std::string& device);
/// Returns whether the number in a device name, such as /dev/ttyUSB0, depends on the order in which devices are plugged
/// in.
[[nodiscard]] bool has_unstable_name(const std::string& device);

struct SerialPortFound {
  std::string device;       ///< "/dev/ttyUSB0"
  std::string description;  ///< "FT232R USB UART - A50285BI"
  std::string serial;       ///< USB adapters only
  /// The path under /dev/serial/by-id, or empty.
  std::string stable_name;
  int vendor{}, product{};  ///< USB adapters only
};
[[nodiscard]] std::vector<SerialPortFound> list_serial_ports();

/// Returns a stream that opens `device` exclusively at first use, and again after it was unplugged. A link is resolved
/// at each opening, and earlier input is discarded. The settings are read back: a port that does not support `format`
/// fails with disconnected and reports its actual settings; a pseudo-terminal has none. After the second consecutive
/// failure, calls fail immediately for 0.5 s, then for longer periods up to 10 s.
[[nodiscard]] std::unique_ptr<ByteStream> make_serial_stream(std::string device, const SerialFormat& format);

/// Wraps `line`, whose adapter echoes everything that is sent, as two-wire RS-485 adapters with an active receiver do.
/// Each write reads its echo and compares it, so reads return only bytes from other devices. Up to `most_stray_bytes`
/// before the echo are ignored, because no answer can precede the echo; a unit that sends lines without a question
/// needs room for one of them. A write fails as a write to `line` does, with timeout if no byte returns within 250 ms,
/// and with corrupted, quoting the returned bytes, if these differ; even then an answer may follow. `clock` must be the
/// clock of `line` and outlive the stream; null means the steady clock.
inline constexpr std::size_t kUsualStrayBytes = 8;
[[nodiscard]] std::unique_ptr<ByteStream> make_echo_stream(std::unique_ptr<ByteStream> line,
                                                           const Clock* clock = nullptr,
                                                           std::size_t most_stray_bytes = kUsualStrayBytes);

}  // namespace gyrotherm::drivers
