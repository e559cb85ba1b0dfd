// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_relay.hpp"

#include <optional>
#include <utility>

#include "simulator/servers/modbus_server.hpp"
#include "simulator/servers/text_unit_session.hpp"

namespace gyrotherm::simulator {
namespace {

class RelayTextSession final : public TextUnitSession {
 public:
  explicit RelayTextSession(VirtualRelay& relay)
      : TextUnitSession({.kind = drivers::LinkKind::text_tcp, .modbus = {}}), relay_(relay) {}

 private:
  std::optional<std::string> answer_line(const std::string& line) override {
    auto answer = relay_.answer(line);
    return answer.empty() ? std::nullopt : std::optional(std::move(answer));
  }

  VirtualRelay& relay_;
};

}  // namespace

VirtualRelay::VirtualRelay(drivers::RelaySettings settings, VirtualLaboratory& laboratory)
    : settings_(std::move(settings)), laboratory_(laboratory) {
  map_.name = "virtual relay";
  map_.link.modbus = apply_settings(drivers::ModbusLink{}, settings_.link);
  if (settings_.is_rtu_over_tcp) map_.link.modbus.framing = drivers::ModbusLink::Framing::rtu;
  map_.link.kind = settings_.is_rtu_over_tcp ? drivers::LinkKind::rtu_over_tcp : drivers::LinkKind::tcp;
  map_.links = {map_.link};
}

void VirtualRelay::switch_to(bool open) {
  if (sticks_) return;
  is_open_ = open;
  laboratory_.cut_power(open);
}

tl::expected<void, ModbusException> VirtualRelay::read(drivers::ReadFunction function, std::uint16_t address,
                                                       std::uint16_t count, std::vector<std::uint16_t>& words) const {
  const auto own = settings_.kind == drivers::RelayKind::coil ? drivers::ReadFunction::coils
                                                              : drivers::ReadFunction::holding_registers;
  if (function != own) return tl::unexpected(ModbusException::illegal_function);
  if (address != settings_.address || count != 1) return tl::unexpected(ModbusException::illegal_address);
  words.push_back(is_open_ ? settings_.open_value : settings_.closed_value);
  return {};
}

tl::expected<void, ModbusException> VirtualRelay::write(drivers::WriteFunction function, std::uint16_t address,
                                                        std::span<const std::uint16_t> words) {
  const auto own =
      settings_.kind == drivers::RelayKind::coil ? drivers::WriteFunction::coil : drivers::WriteFunction::one_register;
  if (function != own) return tl::unexpected(ModbusException::illegal_function);
  if (address != settings_.address) return tl::unexpected(ModbusException::illegal_address);
  const auto word = words.front();
  if (word != settings_.open_value && word != settings_.closed_value)
    return tl::unexpected(ModbusException::illegal_value);
  switch_to(word == settings_.open_value);
  return {};
}

std::string VirtualRelay::answer(const std::string& line) {
  const auto& texts = settings_.texts;
  if (line == texts.tell_open) switch_to(true);
  if (line == texts.tell_close) switch_to(false);
  if (line != texts.ask) return "";
  return is_open_ ? texts.is_open : texts.is_closed;
}

std::unique_ptr<Session> make_relay_session(VirtualRelay& relay) {
  if (relay.settings().kind == drivers::RelayKind::text) return std::make_unique<RelayTextSession>(relay);
  return make_modbus_session(relay);
}

}  // namespace gyrotherm::simulator
