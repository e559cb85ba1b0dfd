// SPDX-License-Identifier: Apache-2.0
/// Where an instrument is connected, as rig files say it, and the line that this stands for.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

enum class SerialParity : std::uint8_t { none, odd, even };

/// Settings of a serial line.
struct SerialFormat {
  int baud = 9600;
  int data_bits = 8;  ///< 7 or 8
  SerialParity parity = SerialParity::none;
  int stop_bits = 1;    ///< 1 or 2
  bool rtscts = false;  ///< hardware handshake
  bool operator==(const SerialFormat&) const = default;
};

/// "9600,7O1": baud, data bits, parity (N, O, E), stop bits; and ",rtscts" for hardware handshake. Fails with bad_file
/// if it is none, or if the baud rate is none of the customary ones from 300 to 921600; `where` is left to the caller.
[[nodiscard]] Result<SerialFormat> parse_serial_format(std::string_view text);
[[nodiscard]] std::string text(const SerialFormat& format);
/// How long one character is on the line, its start bit included.
[[nodiscard]] Duration character_time(const SerialFormat& format);

/// A numeric IPv4 address, because looking up a name has no limit in time; port 0: the instrument's default.
struct TcpLine {
  std::string host;
  std::uint16_t port{};
};
/// A device file, or a link to one (/dev/serial/by-id/…), followed each time it is opened. Without a format: the
/// instrument's default.
struct SerialLine {
  std::string device;
  std::optional<SerialFormat> format;
};
/// An HID device by its serial number; empty: the only one of its kind. The driver knows vendor and product.
struct HidLine {
  std::string serial;
};
/// The simulator's instrument of that place in the rig.
struct VirtualLine {};

using Line = std::variant<VirtualLine, TcpLine, SerialLine, HidLine>;

/// "tcp://10.0.0.7:502", "10.0.0.7", "serial:/dev/ttyUSB0", "serial:/dev/ttyUSB0?9600,7O1", "hid:01234567", "hid:",
/// "virtual". "localhost" is 127.0.0.1. Fails with bad_file; `where` is left to the caller.
[[nodiscard]] Result<Line> parse_line(std::string_view text);
/// As parse_line reads it.
[[nodiscard]] std::string text(const Line& line);

/// Whether make_stream can make one of it: a TCP or a serial line.
[[nodiscard]] bool carries_bytes(const Line& line);

/// What an instrument uses where its line does not say it.
struct LineDefaults {
  std::uint16_t port = 4001;  ///< a serial device server's first line
  SerialFormat serial;
};

/// The line opens at first use, and again after it broke; a TCP connection has `connect_within` to come about. After a
/// second failure in a row the line rests 0.5 s, then longer, up to 10 s; until then every use fails at once. `line`
/// carries bytes.
[[nodiscard]] std::unique_ptr<ByteStream> make_stream(const Line& line, const LineDefaults& defaults,
                                                      Duration connect_within);

// Addresses by which this machine speaks to itself.

/// Whether a numeric IPv4 address leads to this machine: the loopback net, 0.0.0.0, or one of its own interfaces.
[[nodiscard]] bool is_own_address(const std::string& host);

}  // namespace gyrotherm::drivers
