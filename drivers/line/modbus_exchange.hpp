/// The guarded exchange: what Modbus on TCP and on a serial line have in common. Tries, limits, pace, busy units, rests
/// of a failed line, and faults that name their place.
#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "drivers/line/deadline.hpp"
#include "drivers/line/modbus.hpp"
#include "drivers/line/modbus_pdu.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

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

}  // namespace gyrotherm
