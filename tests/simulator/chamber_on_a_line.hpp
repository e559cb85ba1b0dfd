// SPDX-License-Identifier: Apache-2.0
/// Chamber of a register map with both ends of its line: the driver with its frames, and the virtual unit in its
/// laboratory. The exchange keeps the pace of the map's link on a virtual clock.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/servers/modbus_server.hpp"
#include "simulator/servers/text_server.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/hex_bytes.hpp"
#include "tests/support/simulated_line.hpp"

namespace gyrotherm::simulator {

/// Advances the virtual clock instead of waiting.
class ClockPauses final : public drivers::Pauses {
 public:
  explicit ClockPauses(VirtualClock& clock) : clock_(clock) {}
  Duration now() const override { return clock_.now().since_start; }
  void rest(Duration time) override { clock_.advance(time); }

 private:
  VirtualClock& clock_;
};

/// Connection that transfers whole frames. Each frame is answered immediately or never.
class SessionConnection final : public drivers::FrameConnection {
 public:
  using Ask = std::function<std::vector<std::byte>(std::span<const std::byte>)>;
  SessionConnection(VirtualClock& clock, Ask ask) : clock_(clock), ask_(std::move(ask)) {}

  bool is_open() const override { return open_; }
  Result<void> open(Duration) override {
    open_ = true;
    return {};
  }
  void close() override { open_ = false, waiting_.clear(); }
  Result<void> send(std::span<const std::byte> frame) override {
    waiting_ = ask_(frame);
    return {};
  }
  Result<std::size_t> receive(std::span<std::byte> frame, Duration within) override {
    if (waiting_.empty()) {
      clock_.advance(within);
      return failure(FaultKind::timeout, "", "nothing came");
    }
    std::copy(waiting_.begin(), waiting_.end(), frame.begin());
    return std::exchange(waiting_, {}).size();
  }
  bool is_silent_for(Duration time) override {
    clock_.advance(time);
    return true;
  }

 private:
  VirtualClock& clock_;
  Ask ask_;
  std::vector<std::byte> waiting_;
  bool open_ = false;
};

class ChamberOnALine {
 public:
  explicit ChamberOnALine(drivers::RegisterMap described, bool is_marked = false)
      : map(std::move(described)),
        laboratory(laboratory_of_rig("virtual"), {}),
        unit(map, laboratory, is_marked),
        session(map.text_link ? make_text_session(unit, map.link.kind, false) : make_modbus_session(unit)),
        chamber(make_modbus_chamber(map, registers(), std::make_unique<ClockPauses>(clock))) {}
  ChamberOnALine(const std::string& name, drivers::LinkKind kind)
      : ChamberOnALine(select_link(chamber_map(name), kind).value()) {}

  /// Returns a second, independent line to the same unit.
  [[nodiscard]] std::unique_ptr<drivers::Registers> registers() {
    const auto& link = map.link.modbus;
    if (map.text_link) return make_text_registers(map, make_simulated_line(), "line", &clock);
    if (map.link.kind == drivers::LinkKind::tcp) {
      auto connection = std::make_unique<SessionConnection>(clock, [this](auto frame) { return answer(frame); });
      return make_guarded_registers(make_modbus_tcp(std::move(connection), "unit", link, &clock), link, &clock);
    }
    return make_guarded_registers(make_modbus_rtu(make_simulated_line(), "line", link, &clock), link, &clock);
  }

  /// Advances only the laboratory, not the clock of the line.
  void pass(int seconds) {
    for (int i = 0; i < seconds; ++i) {
      unit.advance_second();
      laboratory.step();
    }
  }

  VirtualClock clock;
  drivers::RegisterMap map;
  VirtualLaboratory laboratory;
  ChamberRegisters unit;
  std::unique_ptr<Session> session;
  /// Requests and replies in hexadecimal notation.
  std::vector<std::string> heard;
  std::vector<std::string> said;
  std::unique_ptr<drivers::Chamber> chamber;

 private:
  std::unique_ptr<drivers::ByteStream> make_simulated_line() {
    auto line = std::make_unique<tests::SimulatedLine>(clock);
    auto* end = line.get();
    line->heard = [this, end](std::span<const std::byte> frame) {
      if (auto reply = answer(frame); !reply.empty()) end->arrive(Duration(1000), std::move(reply));
    };
    return line;
  }

  std::vector<std::byte> answer(std::span<const std::byte> frame) {
    heard.push_back(tests::format_hex(frame));
    std::vector<std::byte> reply;
    (void)session->feed(frame, reply);
    said.push_back(tests::format_hex(reply));
    return reply;
  }
};

}  // namespace gyrotherm::simulator
