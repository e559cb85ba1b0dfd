// SPDX-License-Identifier: Apache-2.0
/// Reads every instrument of the rig once a second, and passes commands to the chamber: the one owner of all lines.
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

namespace gyrotherm::io {

/// A thermometer and the names of the inputs that are used: its first ones, in its order.
struct ThermometerInputs {
  drivers::Thermometer& instrument;
  std::vector<std::string> channels;
  KnownAs known{};
};

/// A gyro's line, and what of its counts and values belongs to which unit under test.
struct GyroInputs {
  drivers::Gyro& instrument;
  struct Share {
    std::size_t unit{};                 ///< its place in the sample
    std::vector<std::size_t> axes{};    ///< where each of its axes is among the instrument's
    std::vector<std::size_t> values{};  ///< … and each of its values
  };
  std::vector<Share> shares;
  KnownAs known{};
};

/// A unit of analogue inputs, and whose value each of its readings is.
struct AnalogueChannels {
  drivers::AnalogueInputs& instrument;
  struct Channel {
    std::size_t unit{};   ///< its place in the sample
    std::size_t value{};  ///< … and that of its value there, among the analogue ones
    std::string name{};   ///< "u1.discharge_current_a": the place of its faults
    double scale = 1;     ///< value = reading × scale + offset
    double offset = 0;
  };
  std::vector<Channel> channels;  ///< one for each reading, in their order
  KnownAs known{};
};

/// The instruments of a rig. They must outlive the InstrumentIo, and nobody else calls them while it lives.
struct Instruments {
  drivers::Chamber& chamber;
  std::vector<ThermometerInputs> thermometers;
  std::vector<GyroInputs> gyros;
  std::vector<AnalogueChannels> analogue{};
  const drivers::LineActivity* chamber_line = nullptr;  ///< what the chamber's line did; null: nobody keeps it
  /// Of the axes of a virtual unit, by its place in the sample, in the second that has passed; of a real one nobody
  /// knows it. Asked by inline calls alone.
  std::function<std::vector<DegreesPerHour>(std::size_t unit)> true_bias{};
  KnownAs chamber_known{};
};

struct InstrumentIoOptions {
  Duration interval = std::chrono::seconds(1);         ///< what the gyro shall cover at each read
  Duration patience = std::chrono::milliseconds(900);  ///< workers: after this an instrument counts as silent
  Duration tick = std::chrono::milliseconds(980);  ///< workers: counted from a read, after this a command waits no more
};

/// One thread, that of the tick, calls it.
class InstrumentIo {
 public:
  /// Calls the instruments in the caller's thread, in a fixed order: chamber, thermometers, gyros, analogue inputs. For
  /// virtual time, where a run must be reproducible and a silent device costs no wall time. Nothing is cut off: each
  /// driver's own deadline holds.
  [[nodiscard]] static std::unique_ptr<InstrumentIo> inline_calls(Instruments instruments,
                                                                  InstrumentIoOptions options = {});
  /// Gives each instrument a thread of its own. For real time.
  [[nodiscard]] static std::unique_ptr<InstrumentIo> workers(Instruments instruments, InstrumentIoOptions options = {});
  virtual ~InstrumentIo() = default;

  /// Every instrument once; with workers, back no later than `patience` after the call. An instrument that has not
  /// answered by then has the fault timeout ("still busy after 900 ms") in its own columns; its late answer is dropped,
  /// never taken for a later second's. `clock` stamps sample and readings and must outlive this object. The sample's
  /// `progress` is left for the rig to fill. After a reconnection or a silence an instrument is compared with the one
  /// that it was known as: the reading of another one is the fault mismatch.
  [[nodiscard]] virtual Sample read(std::int64_t slot, const Clock& clock) = 0;

  /// Makes `target` the chamber's set point. Fails as Chamber::send_set_point() does; with workers also with timeout if
  /// that is not done within `patience`, or, after a read, within what that has left of the `tick`: a command that had
  /// not begun by then is not sent later, of one that had the set point is unknown. To another chamber than the one
  /// that it was known as nothing is sent: mismatch; here and below.
  [[nodiscard]] virtual Result<void> send_set_point(Celsius target) = 0;
  /// Does the same at once, also on a line that rests after failures, and with the whole `patience`: for what cannot
  /// wait.
  [[nodiscard]] virtual Result<void> send_set_point_at_once(Celsius target) = 0;
  /// Starts or ends conditioning. Fails as Chamber::start() and stop() do, and like send_set_point().
  [[nodiscard]] virtual Result<void> switch_on(bool on) = 0;

  /// Describes each instrument in whose place another one answered when it was last asked.
  [[nodiscard]] virtual std::vector<std::string> strangers() const { return {}; }

  /// With workers: how long the chamber's call that is under way has not got on, zero if none is: since it began or,
  /// if that is less, since its last exchange ended. A call that hangs shows here, one on a bad line does not. Zero
  /// without workers. The other instruments are not judged: they cannot keep the chamber from being commanded.
  [[nodiscard]] virtual Duration stuck_for() { return {}; }
};

}  // namespace gyrotherm::io
