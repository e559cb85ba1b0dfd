// SPDX-License-Identifier: Apache-2.0
#include "rig/loopback_wires.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/clock.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "rig/thermometer_settings.hpp"

namespace gyrotherm::rig {
namespace {

/// A line to instruments that answer before it is read.
class AttendedStream final : public drivers::ByteStream {
 public:
  /// `instruments`, one of which is at the other end, outlive it.
  AttendedStream(std::unique_ptr<drivers::ByteStream> line, simulator::VirtualInstruments& instruments)
      : line_(std::move(line)), instruments_(instruments) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    return line_->read(buffer, within);
  }
  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    auto written = line_->write(bytes, within);
    if (written) instruments_.attend();
    return written;
  }

 private:
  std::unique_ptr<drivers::ByteStream> line_;
  simulator::VirtualInstruments& instruments_;
};

/// … and one that carries Modbus TCP.
class AttendedConnection final : public drivers::FrameConnection {
 public:
  AttendedConnection(std::unique_ptr<drivers::FrameConnection> connection, simulator::VirtualInstruments& instruments)
      : connection_(std::move(connection)), instruments_(instruments) {}

  bool is_open() const override { return connection_->is_open(); }
  Result<void> open(Duration within) override { return connection_->open(within); }
  void close() override { connection_->close(); }
  Result<void> send(std::span<const std::byte> frame) override {
    auto sent = connection_->send(frame);
    if (sent) instruments_.attend();
    return sent;
  }
  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override {
    return connection_->receive(frame, within);
  }
  bool silent_for(Duration time) override { return connection_->silent_for(time); }

 private:
  std::unique_ptr<drivers::FrameConnection> connection_;
  simulator::VirtualInstruments& instruments_;
};

/// The line of a virtual gyro, on which nothing is waited for while it is switched off: the wait would be one by the
/// clock on the wall.
class LineOfAUnit final : public drivers::ByteStream {
 public:
  /// `instruments`, whose unit it is of, outlive it.
  LineOfAUnit(std::unique_ptr<drivers::ByteStream> line, simulator::VirtualInstruments& instruments)
      : line_(std::move(line)), instruments_(instruments) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    return line_->read(buffer, instruments_.unit().off ? Duration::zero() : within);
  }
  Result<void> write(std::span<const std::byte> bytes, Duration within) override { return line_->write(bytes, within); }

 private:
  std::unique_ptr<drivers::ByteStream> line_;
  simulator::VirtualInstruments& instruments_;
};

class LoopbackWires final : public Wires {
 public:
  LoopbackWires(std::unique_ptr<simulator::VirtualInstruments> instruments, Duration already, Duration later)
      : instruments_(std::move(instruments)), clock_(already - kSecond, later) {}

  std::unique_ptr<drivers::Registers> chamber(const drivers::RegisterMap& map) override {
    return registers(instruments_->chamber_port(), map);
  }
  std::unique_ptr<drivers::Pauses> pauses() override { return drivers::virtual_pauses(); }
  Wire<drivers::ByteStream> thermometer(std::size_t index) override {
    return {.line = attended_stream(instruments_->thermometer_port(index))};
  }
  Wire<drivers::HidReports> usb_temp(std::size_t index) override { return {.line = instruments_->usb_temp(index)}; }
  Wire<drivers::ByteStream> gyro(std::size_t index) override {
    auto line = make_tcp_stream(local(instruments_->gyro_port(index)), kConnectWithin);
    return {.line = std::make_unique<LineOfAUnit>(std::move(line), *instruments_)};
  }
  Wire<drivers::Registers> analogue_input(std::size_t index, const drivers::RegisterMap& map) override {
    return {.line = registers(instruments_->analogue_port(index), map)};
  }

  const Clock& clock() const override { return clock_; }
  void let_pass(std::int64_t seconds) override {
    instruments_->advance(static_cast<int>(seconds));
    clock_.advance(std::chrono::seconds(seconds));
  }
  void bring_units_to(const UnitState& state) override { instruments_->bring_unit_to(state); }
  std::vector<DegreesPerHour> true_bias(const std::string& unit) override {
    const auto& units = instruments_->units();
    const auto found = std::ranges::find(units, unit);
    if (found == units.end()) return {};
    return instruments_->true_bias(static_cast<std::size_t>(found - units.begin()));
  }

 private:
  static drivers::TcpLine local(std::uint16_t port) { return {"127.0.0.1", port}; }

  [[nodiscard]] std::unique_ptr<drivers::ByteStream> attended_stream(std::uint16_t port) {
    return std::make_unique<AttendedStream>(make_tcp_stream(local(port), kConnectWithin), *instruments_);
  }

  [[nodiscard]] std::unique_ptr<drivers::Registers> registers(std::uint16_t port, const drivers::RegisterMap& map) {
    const auto& link = map.link.modbus;
    const auto place = fmt::format("modbus 127.0.0.1:{}", port);
    if (link.framing != drivers::ModbusLink::Framing::tcp)
      return make_guarded_registers(make_modbus_rtu(attended_stream(port), place, link), link);
    auto connection = std::make_unique<AttendedConnection>(drivers::make_modbus_connection(local(port)), *instruments_);
    return make_guarded_registers(make_modbus_tcp(std::move(connection), place, link), link);
  }

  std::unique_ptr<simulator::VirtualInstruments> instruments_;
  VirtualClock clock_;
};

}  // namespace

std::unique_ptr<Wires> make_loopback_wires(std::unique_ptr<simulator::VirtualInstruments> instruments, Duration already,
                                           Duration later) {
  return std::make_unique<LoopbackWires>(std::move(instruments), already, later);
}

}  // namespace gyrotherm::rig
