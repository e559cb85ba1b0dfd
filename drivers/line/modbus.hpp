// SPDX-License-Identifier: Apache-2.0
/// Modbus by the guarded exchange, on whatever line a unit is connected to.
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

/// How one unit wants to be spoken to. A zero duration asks for nothing beyond the framing's own needs.
struct ModbusLink {
  enum class Framing : std::uint8_t { tcp, rtu };  ///< rtu on a TcpLine is RTU over TCP
  Framing framing = Framing::tcp;
  std::uint8_t unit = 1;     ///< 0 is a unit's own number here, no broadcast
  std::uint16_t port = 502;  ///< where a TcpLine names none
  SerialFormat serial;       ///< where a SerialLine names none

  Duration timeout = std::chrono::milliseconds(500);  ///< of one try, from the request's end to the reply's end
  Duration minimum_period{};  ///< from the beginning of one exchange to the beginning of the next
  Duration after_write{};     ///< from the end of a write to the next request
  Duration gap{};             ///< RTU: silence before a request; 0: 3.5 characters
  /// RTU: a reply whose bytes stop for this long is over. Operating systems and gateways deliver in pieces, so this is
  /// longer than the 1.5 characters of the standard; on a slow line it is four characters, over TCP 250 ms, if that is
  /// more.
  Duration piece_gap = std::chrono::milliseconds(30);

  std::uint16_t read_at_most = 125;               ///< registers in one exchange
  std::uint16_t write_at_most = 123;              ///< by WriteFunction::registers
  bool answers_reads_by_either_function = false;  ///< a read by 3 may be answered by 4, and the other way round

  // Deviations of a unit, a gateway or an adapter from the standard. On Modbus TCP the field of a reply may have any
  // value: the length in a reply to a write, the transaction number, the unit number. On RTU the line may return what
  // is sent.
  bool miscounts_write_replies = false;
  bool returns_other_transaction = false;
  bool returns_other_unit = false;
  bool echo = false;

  bool loop_back = false;  ///< RTU: the unit knows function 8, which then finds the beat again after a lost reply

  std::set<std::uint8_t> busy_exceptions{5, 6};           ///< asked again within the limit
  std::map<std::uint8_t, std::string> exception_names{};  ///< where the maker means others than the standard
};

/// The same unit in virtual time: it needs no pauses, and real ones would hold up the run.
[[nodiscard]] ModbusLink without_pauses(ModbusLink link);

/// Registers of the link's unit at the end of `line`, which carries bytes; opened at first use.
///
/// A read has up to three tries within one limit: 1.0 s on TCP, 1.5 s on RTU and on TCP without transaction numbers,
/// and more only where the link's own times leave no room for one try after a lost answer. A unit that says it is busy
/// is asked again within the limit. A write has one try: if it fails, whether it was carried out is unknown until the
/// register is read. After a second failure in a row the line rests 0.5 s, then longer, up to 10 s; until then every
/// use fails at once. An exception is an answer and no failure of the line. Counts are within the link's limits.
///
/// What stands between a reply and its request: see modbus_lines.hpp.
[[nodiscard]] std::unique_ptr<Registers> make_modbus(const Line& line, const ModbusLink& link);

/// One request and its answer, with a framing that tells whether they belong together.
class ModbusLine {
 public:
  virtual ~ModbusLine() = default;
  /// One try, at the pace of the link and over by `deadline`. After anything but an answer the line is left, or will be
  /// made before the next try, such that what still comes on it is not taken for a later answer. Fails with timeout,
  /// disconnected or corrupted.
  [[nodiscard]] virtual Result<ModbusAnswer> ask(ModbusRequest& request, const Deadline& deadline) = 0;
  /// Lets `time` pass, in which nothing may come; what does is never taken for an answer either.
  virtual void rest(Duration time) = 0;
  /// The next try is made at once, also where the line below rests by itself after failures.
  virtual void end_rest() {}
  /// "modbus 10.0.0.7:502"
  [[nodiscard]] virtual std::string place() const = 0;
};

/// When a unit may be asked again.
class Pace {
 public:
  Pace(const ModbusLink& link, const Clock* clock)
      : period_(link.minimum_period),
        after_write_(link.after_write),
        clock_(clock),
        next_(Duration::zero(), clock),
        after_last_write_(Duration::zero(), clock) {}
  [[nodiscard]] Duration left() const { return std::max(next_.left(), after_last_write_.left()); }
  void began() { next_ = Deadline(period_, clock_); }
  void ended(const ModbusRequest& request) {
    if (!reads(request.function)) after_last_write_ = Deadline(after_write_, clock_);
  }

 private:
  Duration period_, after_write_;
  const Clock* clock_;
  Deadline next_, after_last_write_;
};

/// `clock`, if given, must outlive the registers; without one the steady clock counts.
[[nodiscard]] std::unique_ptr<Registers> make_guarded_registers(std::unique_ptr<ModbusLine> line,
                                                                const ModbusLink& link, const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
