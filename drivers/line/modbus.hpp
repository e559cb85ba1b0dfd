// SPDX-License-Identifier: Apache-2.0
/// Modbus client with verified replies, on any line.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Parameters of the link to one unit. A zero duration selects the minimum that the framing requires.
struct ModbusLink {
  enum class Framing : std::uint8_t { tcp, rtu };  ///< rtu: serial, or over TCP
  Framing framing = Framing::tcp;
  /// Unit number; 0 is a normal number, not the broadcast address.
  std::uint8_t unit = 1;
  /// Default port of a TcpLine.
  std::uint16_t port = 502;
  /// Default format of a SerialLine.
  SerialFormat serial;

  /// Maximum time from the end of the request to the end of the reply, in one attempt.
  Duration timeout = std::chrono::milliseconds(500);
  /// Minimum time from the start of one exchange to the start of the next.
  Duration minimum_period{};
  /// Minimum time from the end of a write to the next request.
  Duration after_write{};
  /// RTU: silence before a request; 0 means 3.5 characters.
  Duration gap{};
  /// RTU: a reply ends after this silence. It is longer than the standard's 1.5 characters, because operating systems
  /// and gateways deliver replies in pieces. The minimum in effect is four characters, and 250 ms over TCP.
  Duration piece_gap = std::chrono::milliseconds(30);

  /// Maximum number of registers in one exchange.
  std::uint16_t read_at_most = 125;
  std::uint16_t write_at_most = 123;
  /// Function 4 may answer a read by function 3, and the reverse.
  bool answers_reads_by_either_function = false;

  // Deviations of a unit, gateway or adapter from the standard. In Modbus TCP, the named field of a reply may have any
  // value: the length in a reply to a write, the transaction number, or the unit number. In RTU, the line may echo
  // requests.
  bool miscounts_write_replies = false;
  bool returns_other_transaction = false;
  bool returns_other_unit = false;
  bool echo = false;

  /// RTU: the unit supports function 8 (loop-back), by which the exchange is resynchronised after a lost reply.
  bool loop_back = false;

  /// Exceptions after which the request is repeated.
  std::set<std::uint8_t> busy_exceptions{5, 6};
  /// Names of exceptions with a vendor-specific meaning.
  std::map<std::uint8_t, std::string> exception_names{};
};

/// Returns the link with all pauses removed, for a unit in virtual time.
[[nodiscard]] ModbusLink remove_pauses(ModbusLink link);

/// Returns the registers of the link's unit at the end of `line`, which must satisfy is_byte_line(). The line is
/// opened at first use.
///
/// A read is attempted up to three times within a time limit: 1.0 s for TCP, and 1.5 s for RTU and for TCP without
/// transaction numbers. The limit is longer only if the times of the link would otherwise not permit an attempt after a
/// lost answer. Within the limit, a read is repeated while the unit is busy. A write is attempted once; if it fails,
/// its effect is unknown until the register is read. After the second consecutive failure, calls fail immediately for
/// 0.5 s, then for longer periods up to 10 s. An exception is an answer, not a failure of the line. Counts must be
/// within the link's limits.
///
/// modbus_lines.hpp describes how a reply is matched to its request.
[[nodiscard]] std::unique_ptr<Registers> make_modbus(const Line& line, const ModbusLink& link);

/// A line to one unit, on which each answer is matched to its request.
class ModbusLine {
 public:
  virtual ~ModbusLine() = default;
  /// Sends the request once and returns its answer, by `deadline`. First waits for the pauses that the link requires.
  /// Bytes that arrive after a failed attempt are never accepted as the answer to a later request. Fails with timeout,
  /// disconnected or corrupted.
  [[nodiscard]] virtual Result<ModbusAnswer> try_request(ModbusRequest& request, const Deadline& deadline) = 0;
  /// Sends the request once and ignores its answer, even if the line does not become silent. Fails with disconnected.
  [[nodiscard]] virtual Result<void> send_unconfirmed(ModbusRequest& request, const Deadline& deadline) {
    const auto answer = try_request(request, deadline);
    const bool was_sent = answer || answer.error().kind != FaultKind::disconnected;
    return was_sent ? Result<void>{} : failure(answer.error());
  }
  /// Waits for `time`. Bytes that arrive meanwhile are never accepted as an answer.
  virtual void rest(Duration time) = 0;
  /// Makes the next call try immediately, even if the underlying line is in its rest period after failures.
  virtual void end_rest() {}
  /// Returns the address for messages, such as "modbus 10.0.0.7:502".
  [[nodiscard]] virtual std::string place() const = 0;
};

/// Tracks the earliest time of the next request to a unit, from `minimum_period` and `after_write`.
class Pace {
 public:
  Pace(const ModbusLink& link, const Clock* clock)
      : period_(link.minimum_period),
        after_write_(link.after_write),
        clock_(clock),
        next_(Duration::zero(), clock),
        after_last_write_(Duration::zero(), clock) {}
  [[nodiscard]] Duration left() const { return std::max(next_.left(), after_last_write_.left()); }
  void note_start() { next_ = Deadline(period_, clock_); }
  void note_end(const ModbusRequest& request) {
    if (!is_read(request.function)) after_last_write_ = Deadline(after_write_, clock_);
  }

 private:
  Duration period_, after_write_;
  const Clock* clock_;
  Deadline next_, after_last_write_;
};

/// Returns registers that use `line`, with the retries and rest periods of make_modbus(). `clock` must outlive them;
/// null means the steady clock.
[[nodiscard]] std::unique_ptr<Registers> make_guarded_registers(std::unique_ptr<ModbusLine> line,
                                                                const ModbusLink& link, const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
