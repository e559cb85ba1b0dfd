// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/wires.hpp"

#include <algorithm>
#include <utility>

#include "core/clock.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/modbus_lines.hpp"

namespace gyrotherm::rig {
namespace {

/// A Modbus TCP connection to attended instruments, which answer before the connection is read.
class AttendedConnection final : public drivers::FrameConnection {
 public:
  /// `instruments` contains the far end and must outlive this object.
  AttendedConnection(std::unique_ptr<drivers::FrameConnection> connection, simulator::VirtualInstruments& instruments)
      : connection_(std::move(connection)), instruments_(instruments) {}

  bool is_open() const override { return connection_->is_open(); }
  Result<void> open(Duration within) override { return connection_->open(within); }
  void close() override { connection_->close(); }
  Result<void> send(std::span<const std::byte> frame) override {
    auto sent = connection_->send(frame);
    if (sent) instruments_.serve_clients();
    return sent;
  }
  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override {
    return connection_->receive(frame, within);
  }
  bool is_silent_for(Duration time) override { return connection_->is_silent_for(time); }

 private:
  std::unique_ptr<drivers::FrameConnection> connection_;
  simulator::VirtualInstruments& instruments_;
};

class AttendedWires final : public Wires {
 public:
  AttendedWires(std::unique_ptr<simulator::VirtualInstruments> instruments, Duration elapsed, Duration later)
      : instruments_(std::move(instruments)), clock_(elapsed - kSecond, later) {}

  std::unique_ptr<drivers::Registers> chamber(const drivers::RegisterMap& map) override {
    return registers(InstrumentKind::chamber, 0, map);
  }
  std::unique_ptr<drivers::Pauses> pauses() override { return drivers::make_virtual_pauses(); }
  Wire<drivers::ByteStream> thermometer(std::size_t index) override {
    return {.line = instruments_->line(InstrumentKind::thermometer, index)};
  }
  Wire<drivers::HidReports> usb_temp(std::size_t index) override { return {.line = instruments_->usb_temp(index)}; }
  Wire<drivers::ByteStream> gyro(std::size_t index) override {
    return {.line = instruments_->line(InstrumentKind::gyro, index), .clock = &clock_};
  }
  Wire<drivers::Registers> analogue_input(std::size_t index, const drivers::RegisterMap& map) override {
    return {.line = registers(InstrumentKind::analogue_input, index, map)};
  }
  Wire<drivers::ByteStream> supply(std::size_t index) override {
    return {.line = instruments_->line(InstrumentKind::supply, index)};
  }

  const Clock& clock() const override { return clock_; }
  void let_pass(std::int64_t seconds) override {
    instruments_->advance(static_cast<int>(seconds));
    clock_.advance(std::chrono::seconds(seconds));
  }
  void set_unit_state(const UnitState& state) override { instruments_->set_unit_state(state); }
  std::vector<DegreesPerHour> true_bias(const std::string& unit) override {
    const auto& units = instruments_->units();
    const auto found = std::ranges::find(units, unit);
    if (found == units.end()) return {};
    return instruments_->true_bias(static_cast<std::size_t>(found - units.begin()));
  }

 private:
  using InstrumentKind = simulator::InstrumentKind;
  static constexpr const char* kLineName = "virtual line";

  [[nodiscard]] std::unique_ptr<drivers::Registers> registers(InstrumentKind kind, std::size_t index,
                                                              const drivers::RegisterMap& map) {
    if (is_text(map.link.kind)) return make_text_registers(map, instruments_->line(kind, index), kLineName);
    const auto& link = map.link.modbus;
    if (link.framing != drivers::ModbusLink::Framing::tcp)
      return make_guarded_registers(make_modbus_rtu(instruments_->line(kind, index), kLineName, link), link);
    auto modbus = std::make_unique<AttendedConnection>(
        drivers::make_modbus_connection([this, kind, index] { return instruments_->connect(kind, index); }),
        *instruments_);
    return make_guarded_registers(make_modbus_tcp(std::move(modbus), kLineName, link), link);
  }

  std::unique_ptr<simulator::VirtualInstruments> instruments_;
  VirtualClock clock_;
};

}  // namespace

std::unique_ptr<Wires> make_attended_wires(std::unique_ptr<simulator::VirtualInstruments> instruments, Duration elapsed,
                                           Duration later) {
  return std::make_unique<AttendedWires>(std::move(instruments), elapsed, later);
}

}  // namespace gyrotherm::rig
