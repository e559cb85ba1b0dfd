// SPDX-License-Identifier: Apache-2.0
/// The wires of a virtual rig: the lines that the drivers of a real rig use, with the simulated world and the clock
/// behind them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "drivers/wires.hpp"
#include "simulator/virtual_instruments.hpp"

namespace gyrotherm::rig {

class Wires {
 public:
  /// A line and the clock of its waits.
  template <class Line>
  struct Wire {
    std::unique_ptr<Line> line;
    const Clock* clock = nullptr;
  };

  virtual ~Wires() = default;
  /// Returns the chamber's registers, over the link that `map` selects.
  [[nodiscard]] virtual std::unique_ptr<drivers::Registers> chamber(const drivers::RegisterMap& map) = 0;
  [[nodiscard]] virtual std::unique_ptr<drivers::Pauses> pauses() = 0;
  /// Returns the wire of the byte-oriented thermometer with this index in the rig file.
  [[nodiscard]] virtual Wire<drivers::ByteStream> thermometer(std::size_t index) = 0;
  /// Returns the wire of the USB-TEMP with this index in the rig file.
  [[nodiscard]] virtual Wire<drivers::HidReports> usb_temp(std::size_t index) = 0;
  /// Returns the wire of the gyro line with this index in the rig file. One frame per second arrives on the wire.
  [[nodiscard]] virtual Wire<drivers::ByteStream> gyro(std::size_t line) = 0;

  /// Returns the wire of the analogue input with this index in the rig file, over the link that `map` selects. Returns
  /// an empty wire if the rig has no analogue inputs.
  [[nodiscard]] virtual Wire<drivers::Registers> analogue_input(std::size_t index, const drivers::RegisterMap& map) {
    (void)index, (void)map;
    return {};
  }

  /// Returns the wire of the supply with this index in the rig file. Returns an empty wire if the rig has no supplies.
  [[nodiscard]] virtual Wire<drivers::ByteStream> supply(std::size_t index) {
    (void)index;
    return {};
  }

  /// Returns the rig's clock.
  [[nodiscard]] virtual const Clock& clock() const = 0;
  /// Advances the world behind the wires, and the clock, by whole seconds.
  virtual void let_pass(std::int64_t seconds) = 0;
  /// Sets the state of the units under test behind the wires from the next second on, as an operator would.
  virtual void set_unit_state(const UnitState& state) = 0;
  /// Returns the true bias of a unit's axes in the world behind the wires (VirtualLaboratory::true_bias), or nothing if
  /// it is not available.
  [[nodiscard]] virtual std::vector<DegreesPerHour> true_bias(const std::string& unit) {
    (void)unit;
    return {};
  }
};

/// Returns wires to `instruments`, all within the process. The instruments are attended: each request is answered in
/// the thread that sends it, before that thread waits for the answer. The clock starts at `elapsed` − 1 s, and its UTC
/// is shifted by `later`.
[[nodiscard]] std::unique_ptr<Wires> make_attended_wires(std::unique_ptr<simulator::VirtualInstruments> instruments,
                                                         Duration elapsed, Duration later);

}  // namespace gyrotherm::rig
