/// The wires of one program's life: they end in the plant, which outlives it.
#pragma once

#include <memory>

#include "drivers/line/modbus_rtu.hpp"
#include "rig/wires.hpp"
#include "tests/sequencer/faults/plant.hpp"

namespace gyrotherm {

class LanePauses final : public Pauses {
 public:
  explicit LanePauses(Lane& lane) : lane_(lane) {}
  [[nodiscard]] Duration now() const override { return lane_.time(); }
  void rest(Duration time) override { lane_.pass(time); }

 private:
  Lane& lane_;
};

class MemoryWires final : public Wires {
 public:
  /// Both outlive it.
  MemoryWires(Plant& plant, TrialClock& clock) : plant_(plant), clock_(clock) { plant_.chamber().start_afresh(); }

  std::unique_ptr<Registers> chamber(const RegisterMap& map) override {
    auto& port = plant_.chamber();
    const auto& link = map.link.modbus;
    const auto* clock = &port.line().lane();
    auto line = port.is_tcp()
                    ? make_modbus_tcp(std::make_unique<MemoryConnection>(port), "modbus in memory", link, clock)
                    : make_modbus_rtu(std::make_unique<MemoryStream>(port.line()), "modbus rtu in memory", link, clock);
    return make_guarded_registers(std::move(line), link, clock);
  }
  std::unique_ptr<Pauses> pauses() override { return std::make_unique<LanePauses>(plant_.chamber().line().lane()); }
  Wire<ByteStream> thermometer(std::size_t index) override { return stream(plant_.thermometer(index)); }
  Wire<HidReports> usb_temp(std::size_t) override { return {}; }
  Wire<ByteStream> gyro() override { return stream(plant_.gyro()); }

  const Clock& clock() const override { return clock_; }
  void let_pass(std::int64_t seconds) override {
    for (; seconds > 0; --seconds) {
      clock_.advance(std::chrono::seconds(1));
      plant_.pass_second();
    }
  }

 private:
  static Wire<ByteStream> stream(LineEnd& end) { return {std::make_unique<MemoryStream>(end), &end.lane()}; }

  Plant& plant_;
  TrialClock& clock_;
};

}  // namespace gyrotherm
