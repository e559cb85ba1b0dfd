// SPDX-License-Identifier: Apache-2.0
/// A laboratory power supply that feeds units under test, and its driver for a text protocol that a file describes.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "drivers/supply/supply_description.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Required state of a supply's outputs. `on_after_trip` also clears a trip first.
enum class PowerDemand { keep, on, on_after_trip, off };

/// State of one output, as the supply reports it.
struct OutputReading {
  bool is_on{};
  double voltage_v{};
  double current_a{};
  /// Protections that have tripped: "over_current".
  std::vector<std::string> trips{};
};

/// The result of reading a supply once.
struct SupplyReadings {
  /// One per used output, in the order of the settings.
  std::vector<Result<OutputReading>> outputs;
  /// The demand that has not been verified yet.
  PowerDemand pending = PowerDemand::keep;
  /// Reason why the demand was not carried out at the last attempt; empty if it is in progress or done.
  std::string trouble{};
  /// The demand is not attempted again, because an output tripped.
  bool gave_up{};
};

/// Settings of an output as read back, for people.
struct OutputInspection {
  OutputReading state;
  /// Settings that can be read: "voltage 24 V, current 1 A".
  std::string settings{};
  /// Differences from the settings of the rig file; empty if there are none.
  std::string difference{};
};

/// A supply whose outputs are switched together. Only one thread may call it, except demand().
class PowerSupply : public Identified {
 public:
  /// Requests a state of all used outputs. The next calls of read() carry it out. Any thread.
  virtual void demand(PowerDemand demand) = 0;
  /// Carries out the demand as far as half a second permits, then reads each output.
  ///
  /// Switching on: an output that is on with the right settings is left alone, and one that is on with other settings
  /// is a mismatch, because nothing is changed on a live output. Otherwise the protection levels, the voltage and the
  /// current limit are written and read back in this order, and the output is switched on. Outputs are switched on in
  /// the order of the settings, and off in the reverse order. A switch is done when the supply reports the state and
  /// the measured voltage agrees. It is attempted again in each call, but not after a trip. Voltages are never set to
  /// zero.
  [[nodiscard]] virtual SupplyReadings read() = 0;
  /// Reads the state and the settings of each used output. Changes nothing.
  [[nodiscard]] virtual std::vector<Result<OutputInspection>> inspect() = 0;
};

/// Returns the driver of a supply on the selected link of the description. `place` names the supply in its faults.
/// `clock` is the clock of the stream and must outlive the driver; null means the steady clock. The identity is asked
/// first on each connection and must fit the description. A late answer is never accepted (TextClient).
[[nodiscard]] std::unique_ptr<PowerSupply> make_text_supply(SupplyDescription description,
                                                            std::vector<OutputSettings> outputs,
                                                            std::unique_ptr<ByteStream> stream, std::string place,
                                                            const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
