// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/dcon_server.hpp"

#include <fmt/format.h>

#include <limits>

namespace gyrotherm::simulator {
namespace {

constexpr int kDconDecimals = 2;
constexpr std::size_t kHeadSize = 3;  // of "#AA"
constexpr std::uint8_t kBaud9600 = 0x06, kSumSwitch = 0x40;

std::string setting(const DconModule& module) {
  const auto format = module.checksum == drivers::DconChecksum::on ? kSumSwitch : std::uint8_t{0};
  return drivers::encode_dcon_configuration({.type = module.type, .baud = kBaud9600, .format = format});
}

}  // namespace

std::string DconSession::answer(std::string_view command) const {
  for (const auto& module : modules_) {
    const auto text = unseal_dcon(command, module.checksum);
    if (!text || text->size() < kHeadSize) continue;
    if (text->substr(1, 2) != fmt::format("{:02X}", module.address)) continue;
    const auto reply = answer(module, *text);
    return reply.empty() ? reply : seal_dcon(reply, module.checksum) + "\r";
  }
  return {};
}

std::string DconSession::answer(const DconModule& module, std::string_view command) const {
  const auto what = command.substr(kHeadSize);
  const auto told = [&](std::string_view text) { return fmt::format("!{:02X}{}", module.address, text); };
  if (command[0] == '#') return readings(module, what);
  if (command[0] != '$') return {};
  if (what == "2") return told(setting(module));
  if (what == "6") return told("FF");
  if (what == "M") return told("7018");
  if (what == "F") return told("A0101");
  return fmt::format("?{:02X}", module.address);
}

std::string DconSession::readings(const DconModule& module, std::string_view which) const {
  const auto celsius = laboratory_.thermometers_as_measured_c();
  std::array<double, drivers::kDconInputs> shown{};
  for (std::size_t i = 0; i < shown.size(); ++i)
    shown[i] = module.inputs[i] ? celsius[*module.inputs[i]] : std::numeric_limits<double>::infinity();
  const auto range = drivers::dcon_range(module.type).value_or(drivers::TemperatureRange{});
  if (which.empty()) return drivers::encode_dcon_readings(shown, range, kDconDecimals);
  if (which.size() != 1 || which[0] < '0' || which[0] > '7') return {};
  return drivers::encode_dcon_readings(std::span(shown).subspan(static_cast<std::size_t>(which[0] - '0'), 1), range,
                                       kDconDecimals);
}

}  // namespace gyrotherm::simulator
