// SPDX-License-Identifier: Apache-2.0
/// Wires for one life of the program. They connect to the plant, which outlives the program.
#pragma once

#include <memory>

#include "drivers/line/modbus_lines.hpp"
#include "sequencer/rig/rig.hpp"
#include "tests/sequencer/faults/plant.hpp"

namespace gyrotherm::faults {

class LineClockPauses final : public drivers::Pauses {
 public:
  explicit LineClockPauses(LineClock& line_clock) : line_clock_(line_clock) {}
  [[nodiscard]] Duration now() const override { return line_clock_.time(); }
  void rest(Duration time) override { line_clock_.pass(time); }

 private:
  LineClock& line_clock_;
};

class MemoryWires final : public rig::Wires {
 public:
  /// Both arguments must outlive this object.
  MemoryWires(Plant& plant, SimulatedClock& clock) : plant_(plant), clock_(clock) { plant_.chamber().reset(); }

  std::unique_ptr<drivers::Registers> chamber(const drivers::RegisterMap& map) override {
    auto& port = plant_.chamber();
    const auto& link = map.link.modbus;
    const auto* clock = &port.line().line_clock();
    auto line = port.is_tcp()
                    ? make_modbus_tcp(std::make_unique<MemoryConnection>(port), "modbus in memory", link, clock)
                    : make_modbus_rtu(std::make_unique<MemoryStream>(port.line()), "modbus rtu in memory", link, clock);
    return make_guarded_registers(std::move(line), link, clock);
  }
  std::unique_ptr<drivers::Pauses> pauses() override {
    return std::make_unique<LineClockPauses>(plant_.chamber().line().line_clock());
  }
  Wire<drivers::ByteStream> thermometer(std::size_t index) override { return stream(plant_.thermometer(index)); }
  Wire<drivers::HidReports> usb_temp(std::size_t) override { return {}; }
  Wire<drivers::ByteStream> gyro(std::size_t line) override { return stream(plant_.gyro(line).line()); }
  Wire<drivers::ByteStream> supply(std::size_t index) override { return stream(plant_.supply_line(index)); }

  const Clock& clock() const override { return clock_; }
  void let_pass(std::int64_t seconds) override {
    for (; seconds > 0; --seconds) {
      clock_.advance(std::chrono::seconds(1));
      plant_.advance_second();
    }
  }
  void set_unit_state(const UnitState& state) override { plant_.laboratory().set_unit_state(state); }

 private:
  static Wire<drivers::ByteStream> stream(LineEnd& end) {
    return {std::make_unique<MemoryStream>(end), &end.line_clock()};
  }

  Plant& plant_;
  SimulatedClock& clock_;
};

}  // namespace gyrotherm::faults
