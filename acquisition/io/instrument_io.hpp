// SPDX-License-Identifier: Apache-2.0
/// Reads every instrument of the rig once a second and passes commands to the chamber. No other class uses the
/// communication lines of the instruments.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/io/identity_watch.hpp"
#include "core/clock.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/supply/power_supply.hpp"

namespace gyrotherm::io {

/// A thermometer and the names of its channels. The channels are the first inputs of the instrument, in the
/// instrument's order.
struct ThermometerInputs {
  drivers::Thermometer& instrument;
  std::vector<std::string> channels;
  KnownIdentity known{};
};

/// A gyro instrument, and the assignment of its counts and values to the units under test.
struct GyroInputs {
  drivers::Gyro& instrument;
  /// The axes and values that belong to one unit.
  struct Share {
    std::size_t unit{};  ///< index in Sample::units
    /// For each axis of the unit, its index among the instrument's axes.
    std::vector<std::size_t> axes{};
    /// For each value of the unit, its index among the instrument's values.
    std::vector<std::size_t> values{};
  };
  std::vector<Share> shares;
  KnownIdentity known{};
};

/// An instrument with analogue inputs, and the assignment of its readings to values of the units under test.
struct AnalogueChannels {
  drivers::AnalogueInputs& instrument;
  /// The destination of one reading: value = reading × scale + offset. `unit` is an index in Sample::units and `value`
  /// one in UnitReading::analogue.
  struct Channel {
    std::size_t unit{};
    std::size_t value{};
    /// The location that its faults name: "u1.discharge_current_a".
    std::string name{};
    double scale = 1;
    double offset = 0;
  };
  /// One channel per reading, in the same order.
  std::vector<Channel> channels;
  KnownIdentity known{};
};

/// A power supply, and the assignment of its outputs to values of the units under test.
struct SupplyChannels {
  drivers::PowerSupply& instrument;
  /// The destination of one output's readings. `unit` is an index in Sample::units, and the others are indices in
  /// UnitReading::analogue.
  struct Channel {
    std::size_t unit{};
    std::size_t voltage{};
    std::size_t current{};
    /// The location that its faults name: "supply 1, output 1".
    std::string name{};
  };
  /// The channels of each used output, one for each unit that it feeds.
  std::vector<std::vector<Channel>> outputs;
  KnownIdentity known{};
};

/// The instruments of a rig. They must outlive the InstrumentIo, which must be their only user during its lifetime.
struct Instruments {
  drivers::Chamber& chamber;
  std::vector<ThermometerInputs> thermometers;
  std::vector<GyroInputs> gyros;
  std::vector<AnalogueChannels> analogue{};
  std::vector<SupplyChannels> supplies{};
  /// The activity of the chamber's line; null if it is not recorded.
  const drivers::LineActivity* chamber_line = nullptr;
  /// Returns the true bias of each axis of a virtual unit in the past second. The argument is the index in
  /// Sample::units. Empty for a real rig. Only inline_calls() uses it.
  std::function<std::vector<DegreesPerHour>(std::size_t unit)> true_bias{};
  KnownIdentity chamber_known{};
};

struct InstrumentIoOptions {
  /// Duration that each gyro reading covers.
  Duration interval = std::chrono::seconds(1);
  /// Workers only: longest wait for an instrument's answer.
  Duration patience = std::chrono::milliseconds(900);
  /// Workers only: latest time after the start of a read until which a command is awaited.
  Duration tick = std::chrono::milliseconds(980);
};

/// The interface to all instruments. Only the thread of the tick calls it.
class InstrumentIo {
 public:
  /// Calls the instruments in the caller's thread, in a fixed order: chamber, thermometers, gyros, analogue inputs,
  /// supplies.
  /// Intended for virtual time: runs are reproducible, and a silent device costs no wall time. Calls are not limited in
  /// time except by each driver's own deadline.
  [[nodiscard]] static std::unique_ptr<InstrumentIo> inline_calls(Instruments instruments,
                                                                  InstrumentIoOptions options = {});
  /// Gives each instrument a thread of its own. Intended for real time.
  [[nodiscard]] static std::unique_ptr<InstrumentIo> workers(Instruments instruments, InstrumentIoOptions options = {});
  virtual ~InstrumentIo() = default;

  /// Reads every instrument once. With workers it returns at most `patience` after the call. An instrument that has not
  /// answered by then gets the fault timeout ("still busy after 900 ms") in its own columns. Its late answer is dropped
  /// and never used for a later second; the fault quotes the last line that the driver could not understand.
  /// `clock` stamps the sample and its readings and must outlive this object. The rig sets the sample's `progress`. The
  /// identity of an instrument is compared with the known one after a reconnection or a silence. If another instrument
  /// answers, its reading is the fault mismatch.
  [[nodiscard]] virtual Sample read(std::int64_t slot, const Clock& clock) = 0;

  /// Sends the set point `target` to the chamber. Fails as Chamber::send_set_point() does. With workers it also fails
  /// with timeout if the command does not complete within `patience` or, after a read, within the remainder of the
  /// `tick`. If the command had not begun by then, it is withdrawn. If it had begun, it is unknown whether the chamber
  /// has received the set point. Fails with mismatch and sends nothing if another chamber answers; this applies to all
  /// commands.
  [[nodiscard]] virtual Result<void> send_set_point(Celsius target) = 0;
  /// Sends a set point immediately, even on a line that pauses after failures, and waits up to the full `patience` for
  /// the result. Intended for urgent commands.
  [[nodiscard]] virtual Result<void> send_set_point_immediately(Celsius target) = 0;
  /// Sends the safe set point immediately, but waits only for the remainder of the `tick`. With workers, a command that
  /// has not begun by then stays the next call of the chamber, before its next reading; a later call returns its
  /// result. If the chamber was identified when the run began and its answers are missing or cannot be understood, the
  /// commands of the safe state are sent without an answer, with the stop if `off`
  /// (Chamber::send_safe_state_unconfirmed). The result remains a failure then.
  [[nodiscard]] virtual Result<void> send_safe_set_point(Celsius target, bool off) {
    (void)off;
    return send_set_point_immediately(target);
  }
  /// Starts or stops conditioning. Fails as Chamber::start() and stop() do, and like send_set_point().
  [[nodiscard]] virtual Result<void> switch_on(bool on) = 0;

  /// Requests a state of a supply's outputs. The next calls of read() carry it out (PowerSupply::demand).
  virtual void demand_power(std::size_t supply, drivers::PowerDemand demand) { (void)supply, (void)demand; }
  /// Returns the readings of each supply in the last second. A supply that did not answer has a fault in each output.
  [[nodiscard]] virtual const std::vector<drivers::SupplyReadings>& supplies() const {
    static const std::vector<drivers::SupplyReadings> none;
    return none;
  }

  /// Returns the time by which, since the last read began, a wait for the chamber exceeded the tick. Zero without
  /// workers.
  [[nodiscard]] virtual Duration overtime() const { return {}; }

  /// Describes each instrument that answered in place of the known one when identities were last compared.
  [[nodiscard]] virtual std::vector<std::string> mismatched_instruments() const { return {}; }

  /// Returns the time for which, with workers, the chamber's present call has made no progress: since the call began or
  /// since its last exchange ended, whichever is later. Returns zero if no call is active, or without workers. The
  /// value is large for a call that hangs, but not for a call that is slow because of retries on a bad line. The other
  /// instruments are not included, because they cannot delay commands to the chamber.
  [[nodiscard]] virtual Duration stuck_for() { return {}; }
};

}  // namespace gyrotherm::io
