// SPDX-License-Identifier: Apache-2.0
/// Interfaces of the transports below the drivers: real lines, sockets to virtual instruments, and in-memory fakes
/// implement them. Every wait is limited by `within`, measured by the transport's clock.
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

/// Modbus function of a read, which selects one of a unit's four tables (Modbus Application Protocol V1.1b3, section
/// 6).
enum class ReadFunction : std::uint8_t { coils = 1, discrete_inputs = 2, holding_registers = 3, input_registers = 4 };
/// Modbus function of a write. `coil` and `one_register` need one exchange per word; `registers` writes all words in
/// one exchange.
enum class WriteFunction : std::uint8_t { coil = 5, one_register = 6, registers = 16 };

/// The registers and bits of one Modbus unit. Addresses are zero-based, as on the wire. A coil or discrete input is a
/// word that is 0 or 1.
class Registers {
 public:
  virtual ~Registers() = default;
  /// Reads `count` words. Fails with timeout, disconnected or corrupted (the reply does not belong to the request). A
  /// Modbus exception fails with refused (no such register), out_of_range (no value at present) or timeout (busy), and
  /// is named in the text.
  [[nodiscard]] virtual Result<std::vector<std::uint16_t>> read(ReadFunction function, std::uint16_t address,
                                                                std::uint16_t count) = 0;
  /// Writes words. Fails as read() does, at the first exchange that fails. An acknowledged write may not have taken
  /// effect yet; read it back to verify it.
  [[nodiscard]] virtual Result<void> write(WriteFunction function, std::uint16_t address,
                                           std::span<const std::uint16_t> words) = 0;
  /// Writes words although the replies of the unit cannot be understood, and ignores the reply. Success means only that
  /// the request was sent. Ignores rest periods. Fails with disconnected, and with refused if the unit's protocol does
  /// not permit it.
  [[nodiscard]] virtual Result<void> write_unconfirmed(WriteFunction function, std::uint16_t address,
                                                       std::span<const std::uint16_t> words) {
    (void)function, (void)address, (void)words;
    return failure(FaultKind::refused, "", "nothing is written without a reply");
  }
  /// Makes the next call try immediately, even if the line is in its rest period after failures. For urgent commands.
  virtual void end_rest() {}
  /// Returns the number of connections that broke so far. After a break, another instrument may answer.
  [[nodiscard]] virtual std::uint64_t breaks() const { return 0; }
};

/// A bidirectional line for bytes, such as a socket or a serial port.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Reads the available bytes, waiting for at least one. Fails with timeout (no byte arrived) or disconnected.
  [[nodiscard]] virtual Result<std::size_t> read(std::span<std::byte> buffer, Duration within) = 0;
  /// Returns the arrival time, on the steady clock, of the newest byte of the last read. Returns nothing if bytes are
  /// always read when they arrive.
  [[nodiscard]] virtual std::optional<Duration> arrival_time() const { return {}; }
  /// Writes all bytes. Fails with timeout or disconnected.
  [[nodiscard]] virtual Result<void> write(std::span<const std::byte> bytes, Duration within) = 0;
  /// Makes the next call try immediately, even if the line is in its rest period after failures.
  virtual void end_rest() {}
};

/// An HID device that exchanges reports; byte 0 of a report is its number. The device is opened at first use. After it
/// was unplugged, it is found again by its serial number.
class HidReports {
 public:
  virtual ~HidReports() = default;
  /// Opens the device unless it is open. Returns its model and serial number. Fails with disconnected.
  [[nodiscard]] virtual Result<std::string> open() = 0;
  /// Sends one output report of at least two bytes. Fails with disconnected.
  [[nodiscard]] virtual Result<void> write(std::span<const std::byte> report) = 0;
  /// Reads the next input report into `report` and returns its size. Fails with timeout (no report arrived) or
  /// disconnected.
  [[nodiscard]] virtual Result<std::size_t> read(std::span<std::byte> report, Duration within) = 0;
};

}  // namespace gyrotherm::drivers
