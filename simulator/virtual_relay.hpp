// SPDX-License-Identifier: Apache-2.0
/// The virtual relay of a chamber ([safe.also]): while it is open, the chamber's machinery has no power. Its controller
/// has a supply of its own and continues to answer.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/supply/safety_relay.hpp"
#include "simulator/served_registers.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

class VirtualRelay final : public ServedRegisters {
 public:
  /// `laboratory` must outlive the relay.
  VirtualRelay(drivers::RelaySettings settings, VirtualLaboratory& laboratory);

  [[nodiscard]] const drivers::RegisterMap& map() const override { return map_; }
  [[nodiscard]] tl::expected<void, ModbusException> read(drivers::ReadFunction function, std::uint16_t address,
                                                         std::uint16_t count,
                                                         std::vector<std::uint16_t>& words) const override;
  [[nodiscard]] tl::expected<void, ModbusException> write(drivers::WriteFunction function, std::uint16_t address,
                                                          std::span<const std::uint16_t> words) override;
  /// Returns the answer of a relay with text commands; empty if it sends none.
  [[nodiscard]] std::string answer(const std::string& line);
  /// A relay that sticks acknowledges each command and keeps its position.
  void stick(bool sticks) { sticks_ = sticks; }
  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] const drivers::RelaySettings& settings() const { return settings_; }

 private:
  void switch_to(bool open);

  drivers::RelaySettings settings_;
  VirtualLaboratory& laboratory_;
  drivers::RegisterMap map_;
  bool is_open_ = false, sticks_ = false;
};

/// Returns a session with the relay in its protocol.
[[nodiscard]] std::unique_ptr<Session> make_relay_session(VirtualRelay& relay);

}  // namespace gyrotherm::simulator
