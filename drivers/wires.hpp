/// The small interfaces below the drivers. Real lines, sockets to virtual instruments and in-memory fakes stand behind
/// them. Every wait has a limit, `within`, on the clock of whoever made the wire.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// 16-bit holding registers of one Modbus unit. An address is the one on the wire (zero-based).
class Registers {
 public:
  virtual ~Registers() = default;
  /// Fails with timeout, disconnected, refused (an exception reply, which is named) or corrupted (a reply that is not
  /// the answer to this request).
  [[nodiscard]] virtual Result<std::vector<std::uint16_t>> read(std::uint16_t address, std::uint16_t count) = 0;
  /// An acknowledged write is not yet an applied one: read it back.
  [[nodiscard]] virtual Result<void> write(std::uint16_t address, std::span<const std::uint16_t> words) = 0;
};

/// A line that carries bytes both ways: a socket, a serial port.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Reads what has come, at least one byte. Fails with timeout (nothing came) or disconnected.
  [[nodiscard]] virtual Result<std::size_t> read(std::span<std::byte> buffer, Duration within) = 0;
  /// Writes all. Fails with timeout or disconnected.
  [[nodiscard]] virtual Result<void> write(std::span<const std::byte> bytes, Duration within) = 0;
};

/// Where an instrument is connected: "tcp://host:port". The host is a numeric IPv4 address (or "localhost"), because
/// looking up a name has no limit in time.
struct LineAddress {
  std::string host;
  std::uint16_t port{};
};
/// "tcp://127.0.0.1:5020", "10.0.0.7". Fails with bad_file; `where` is left to the caller.
[[nodiscard]] Result<LineAddress> parse_line_address(std::string_view text, std::uint16_t default_port);

}  // namespace gyrotherm
