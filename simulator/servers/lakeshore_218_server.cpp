// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/lakeshore_218_server.hpp"

#include "core/quantity.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr int kCrdgDecimals = 3;

}  // namespace

std::string Lakeshore218Session::answer(std::string_view command) const {
  if (command == "*IDN?") return "LSCI,MODEL218S,VIRTUAL1,010126\r\n";
  if (command.starts_with("CRDG?")) return readings(without_blanks(command.substr(5)), 0);
  if (command.starts_with("KRDG?")) return readings(without_blanks(command.substr(5)), kZeroCelsiusInKelvin);
  return {};
}

std::string Lakeshore218Session::readings(std::string_view argument, double zero_c) const {
  const auto celsius = laboratory_.thermometers_as_measured_c();
  std::array<double, drivers::kLakeshore218Inputs> shown{};
  for (std::size_t i = 0; i < shown.size(); ++i) {
    shown[i] = (inputs_[i] ? celsius[*inputs_[i]] : -kZeroCelsiusInKelvin) + zero_c;
  }
  if (argument.empty() || argument == "0") return drivers::encode_crdg(shown, kCrdgDecimals) + "\r\n";
  const bool one_input = argument.size() == 1 && argument[0] >= '1' && argument[0] <= '8';
  if (!one_input) return {};
  return drivers::encode_crdg(std::span(shown).subspan(static_cast<std::size_t>(argument[0] - '1'), 1), kCrdgDecimals) +
         "\r\n";
}

}  // namespace gyrotherm::simulator
