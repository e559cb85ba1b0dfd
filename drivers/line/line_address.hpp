// SPDX-License-Identifier: Apache-2.0
/// Addresses of instruments in rig files, and the lines to which they refer.
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
  bool rtscts = false;  ///< hardware flow control
  bool operator==(const SerialFormat&) const = default;
};

/// Parses "9600,7O1": baud rate, data bits, parity (N, O, E) and stop bits, with ",rtscts" for hardware flow control.
/// Fails with bad_file on other text, or if the baud rate is not a standard one from 300 to 2000000. The caller sets
/// `where`.
[[nodiscard]] Result<SerialFormat> parse_serial_format(std::string_view text);
[[nodiscard]] std::string text(const SerialFormat& format);
/// Returns the duration of one character on the line, including its start bit.
[[nodiscard]] Duration character_time(const SerialFormat& format);

/// A TCP address. The host is a numeric IPv4 address, because name lookup has no time limit. Port 0 means the
/// instrument's default.
struct TcpLine {
  std::string host;
  std::uint16_t port{};
};
/// A device file, or a link to one (/dev/serial/by-id/…) that is resolved at each opening. An empty format means the
/// instrument's default.
struct SerialLine {
  std::string device;
  std::optional<SerialFormat> format;
};
/// An HID device with this serial number; if the number is empty, the only connected device of its kind. The driver
/// defines the vendor and product numbers.
struct HidLine {
  std::string serial;
};
/// The simulator's instrument at the same position in the rig file.
struct VirtualLine {};

using Line = std::variant<VirtualLine, TcpLine, SerialLine, HidLine>;

/// Parses an address: "tcp://10.0.0.7:502", "10.0.0.7", "serial:/dev/ttyUSB0", "serial:/dev/ttyUSB0?9600,7O1",
/// "hid:01234567", "hid:" or "virtual". "localhost" is 127.0.0.1. Fails with bad_file; the caller sets `where`.
[[nodiscard]] Result<Line> parse_line(std::string_view text);
/// Formats an address for parse_line().
[[nodiscard]] std::string text(const Line& line);

/// Returns whether make_stream() accepts the line: a TCP or a serial line.
[[nodiscard]] bool is_byte_line(const Line& line);

/// Default values of an instrument for a line address that does not contain them.
struct LineDefaults {
  /// Usual first port of a serial device server.
  std::uint16_t port = 4001;
  SerialFormat serial;
};

/// Returns a stream that opens at first use and again after the line broke. Connecting by TCP may take up to
/// `connect_within`. After the second consecutive failure, calls fail immediately for 0.5 s, then for longer periods up
/// to 10 s. `line` must satisfy is_byte_line().
[[nodiscard]] std::unique_ptr<ByteStream> make_stream(const Line& line, const LineDefaults& defaults,
                                                      Duration connect_within);

/// Returns whether a numeric IPv4 address refers to this machine: the loopback network, 0.0.0.0, or one of its
/// interfaces.
[[nodiscard]] bool is_local_address(const std::string& host);

}  // namespace gyrotherm::drivers
