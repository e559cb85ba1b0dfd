// SPDX-License-Identifier: Apache-2.0
/// The small interfaces below the drivers. Real lines, sockets to virtual instruments and in-memory fakes stand behind
/// them. Every wait has a limit, `within`, on the clock of whoever made the wire.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::drivers {

/// By which function a unit is asked, and so which of its four tables (Modbus Application Protocol V1.1b3, section 6).
enum class ReadFunction : std::uint8_t { coils = 1, discrete_inputs = 2, holding_registers = 3, input_registers = 4 };
/// `coil` and `one_register` write one word per exchange, one after the other; `registers` writes all in one.
enum class WriteFunction : std::uint8_t { coil = 5, one_register = 6, registers = 16 };

/// The registers and bits of one Modbus unit. An address is the one on the wire (zero-based). A coil or discrete input
/// is a word that is 0 or 1.
class Registers {
 public:
  virtual ~Registers() = default;
  /// Fails with timeout, disconnected, corrupted (a reply that is not the answer to this request), or by an exception,
  /// which is named: refused (there is no such register), out_of_range (it has no value now) or timeout (busy).
  [[nodiscard]] virtual Result<std::vector<std::uint16_t>> read(ReadFunction function, std::uint16_t address,
                                                                std::uint16_t count) = 0;
  /// Fails likewise; of several exchanges the first that fails is the last. An acknowledged write is not yet an applied
  /// one: read it back.
  [[nodiscard]] virtual Result<void> write(WriteFunction function, std::uint16_t address,
                                           std::span<const std::uint16_t> words) = 0;
  /// The next use is tried at once, also on a line that rests after failures: for what cannot wait.
  virtual void end_rest() {}
  /// Counts the connections that broke so far. Another instrument may be at the end of the next one.
  [[nodiscard]] virtual std::uint64_t breaks() const { return 0; }
};

/// A line that carries bytes both ways: a socket, a serial port.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Reads what has come, at least one byte. Fails with timeout (nothing came) or disconnected.
  [[nodiscard]] virtual Result<std::size_t> read(std::span<std::byte> buffer, Duration within) = 0;
  /// When the newest of the bytes that the last read gave had come, on the steady clock; nothing if it gave them as
  /// they came.
  [[nodiscard]] virtual std::optional<Duration> came() const { return {}; }
  /// Writes all. Fails with timeout or disconnected.
  [[nodiscard]] virtual Result<void> write(std::span<const std::byte> bytes, Duration within) = 0;
  /// The next use is tried at once, also on a line that rests after failures: how Registers::end_rest() reaches it.
  virtual void end_rest() {}
};

/// An HID device that is spoken to in reports; byte 0 of a report is its number. Opened at first use, found again by
/// its serial number after it was gone.
class HidReports {
 public:
  virtual ~HidReports() = default;
  /// Who it is: model and serial number. Opens the device if it is not open. Fails with disconnected.
  [[nodiscard]] virtual Result<std::string> open() = 0;
  /// Sends one output report of two bytes or more. Fails with disconnected.
  [[nodiscard]] virtual Result<void> write(std::span<const std::byte> report) = 0;
  /// The next input report, into `report`; its size. Fails with timeout (none came) or disconnected.
  [[nodiscard]] virtual Result<std::size_t> read(std::span<std::byte> report, Duration within) = 0;
};

}  // namespace gyrotherm::drivers
