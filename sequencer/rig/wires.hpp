// SPDX-License-Identifier: Apache-2.0
/// The wires of a virtual rig: lines below the drivers of a real rig, and the world and the clock behind them.
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
  /// Returns the chamber's registers on the map's link in use.
  [[nodiscard]] virtual std::unique_ptr<drivers::Registers> chamber(const drivers::RegisterMap& map) = 0;
  [[nodiscard]] virtual std::unique_ptr<drivers::Pauses> pauses() = 0;
  /// Returns the wire of a byte-oriented thermometer, by its index in the rig file.
  [[nodiscard]] virtual Wire<drivers::ByteStream> thermometer(std::size_t index) = 0;
  /// Returns the wire of a USB-TEMP, by its index in the rig file.
  [[nodiscard]] virtual Wire<drivers::HidReports> usb_temp(std::size_t index) = 0;
  /// Returns the wire of a gyro line, by its index in the rig file. One frame a second arrives on it.
  [[nodiscard]] virtual Wire<drivers::ByteStream> gyro(std::size_t line) = 0;

  /// Returns the wire of an analogue input, by its index in the rig file, on its map's link in use; nothing if the rig
  /// has none.
  [[nodiscard]] virtual Wire<drivers::Registers> analogue_input(std::size_t index, const drivers::RegisterMap& map) {
    (void)index, (void)map;
    return {};
  }

  /// Returns the rig's clock.
  [[nodiscard]] virtual const Clock& clock() const = 0;
  /// Advances the world behind the wires, and the clock, by whole seconds.
  virtual void let_pass(std::int64_t seconds) = 0;
  /// Brings that world's units under test to a state from the next second on, as people would.
  virtual void bring_units_to(const UnitState& state) = 0;
  /// Returns the true bias of a unit's axes in that world (VirtualLaboratory::true_bias), or nothing if it is not
  /// available.
  [[nodiscard]] virtual std::vector<DegreesPerHour> true_bias(const std::string& unit) {
    (void)unit;
    return {};
  }
};

/// Returns wires to `instruments`, all within the process. The instruments are attended: each request is answered in
/// the thread that sends it, before that thread waits for the answer. The clock starts at `already` − 1 s, and its days
/// are `later`.
[[nodiscard]] std::unique_ptr<Wires> make_attended_wires(std::unique_ptr<simulator::VirtualInstruments> instruments,
                                                         Duration already, Duration later);

}  // namespace gyrotherm::rig
