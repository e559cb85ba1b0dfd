// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/wires.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

#include "core/clock.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "drivers/line/modbus_lines.hpp"

namespace gyrotherm::rig {
namespace {

/// A Modbus TCP connection over a line in memory, whose instrument answers while the request is sent. Nothing arrives
/// later, so no call waits.
class LineConnection final : public drivers::FrameConnection {
 public:
  using OpenLine = std::function<std::unique_ptr<drivers::ByteStream>()>;
  explicit LineConnection(OpenLine open_line) : open_line_(std::move(open_line)) {}

  bool is_open() const override { return line_ != nullptr; }
  Result<void> open(Duration) override {
    line_ = open_line_();
    return {};
  }
  void close() override {
    line_.reset();
    received_ = 0;
  }
  Result<void> send(std::span<const std::byte> frame) override { return line_->write(frame, Duration::zero()); }

  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override {
    while (true) {
      const auto size = drivers::frame_length(std::span(bytes_).first(received_));
      if (!size) return failure(size.error());
      if (*size) return take(**size, frame);
      if (auto more = read_more(within); !more) return failure(more.error());
    }
  }
  bool is_silent_for(Duration time) override { return line_ == nullptr || (received_ == 0 && !read_more(time)); }

 private:
  /// Reads available bytes behind those already received.
  [[nodiscard]] Result<void> read_more(Duration within) {
    return line_->read(std::span(bytes_).subspan(received_), within).map([this](std::size_t size) {
      received_ += size;
    });
  }
  std::size_t take(std::size_t size, std::span<std::byte> frame) {
    const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(size);
    std::copy(bytes_.begin(), end, frame.begin());
    std::copy(end, bytes_.begin() + static_cast<std::ptrdiff_t>(received_), bytes_.begin());
    received_ -= size;
    return size;
  }

  OpenLine open_line_;
  std::unique_ptr<drivers::ByteStream> line_;
  /// Received bytes that receive() has not returned. A frame has at most 260 bytes.
  std::array<std::byte, 520> bytes_{};
  std::size_t received_ = 0;
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
    auto modbus = std::make_unique<LineConnection>([this, kind, index] { return instruments_->line(kind, index); });
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
