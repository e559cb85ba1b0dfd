// SPDX-License-Identifier: Apache-2.0
/// A unit at one end of a simulated serial line, and a client with registers at the other end.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <vector>

#include "drivers/line/byte_streams.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "drivers/line/modbus_lines.hpp"
#include "tests/drivers/line/words.hpp"
#include "tests/support/simulated_line.hpp"

namespace gyrotherm::drivers {

using std::chrono::milliseconds;
inline constexpr auto kHolding = ReadFunction::holding_registers;
inline constexpr Duration kSoon = milliseconds(5), kTimeout = milliseconds(200);

inline ModbusLink usual() {
  ModbusLink link;
  link.framing = ModbusLink::Framing::rtu;
  link.timeout = kTimeout;
  return link;
}

/// Returns a reply in which each register holds its own address.
inline Bytes good(const ModbusRequest& request) {
  Words words(is_read(request.function) ? request.count : 0u);
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = static_cast<std::uint16_t>(request.address + i);
  return encode_rtu_reply(request, words);
}

class OnASimulatedLine : public testing::Test {
 protected:
  using Behaviour = std::function<void(int number, const ModbusRequest& request, const Bytes& frame)>;

  OnASimulatedLine() { connect(usual()); }

  void connect(const ModbusLink& link) {
    auto made = std::make_unique<tests::SimulatedLine>(clock);
    line = made.get();
    line->heard = [this](std::span<const std::byte> frame) {
      asked_at.push_back(line->now());
      const auto request = decode_rtu_request(frame);
      ASSERT_TRUE(request) << text(request.error());
      unit(static_cast<int>(asked_at.size()) - 1, *request, Bytes(frame.begin(), frame.end()));
    };
    std::unique_ptr<ByteStream> stream = std::move(made);
    if (link.echo) stream = make_echo_stream(std::move(stream), &clock);
    registers =
        make_guarded_registers(make_modbus_rtu(std::move(stream), "modbus rtu line", link, &clock), link, &clock);
  }
  [[nodiscard]] std::size_t requests() const { return asked_at.size(); }
  [[nodiscard]] Duration now() const { return clock.now().since_start; }

  VirtualClock clock;
  tests::SimulatedLine* line{};
  std::vector<Duration> asked_at;
  Behaviour unit = [this](int, const ModbusRequest& request, const Bytes&) { line->arrive(kSoon, good(request)); };
  std::unique_ptr<Registers> registers;
};

}  // namespace gyrotherm::drivers
