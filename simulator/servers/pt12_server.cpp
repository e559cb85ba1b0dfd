// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/pt12_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <vector>

namespace gyrotherm::simulator {
namespace {

/// n of "TN?", from 1; 0 if `command` is none.
std::size_t input_of(std::string_view command) {
  if (command.size() < 3 || command.front() != 'T' || command.back() != '?') return 0;
  const auto digits = command.substr(1, command.size() - 2);
  std::size_t input{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), input);
  return error == std::errc{} && end == digits.data() + digits.size() && input <= drivers::kPt12Inputs ? input : 0;
}

}  // namespace

std::string Pt12Session::connected() const {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    if (inputs_[i]) numbers.push_back(i + 1);
  return fmt::format("{}\r\n", fmt::join(numbers, ", "));
}

std::string Pt12Session::answer(std::string_view command) const {
  std::string upper(command);
  std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  if (upper == "ID?") return "PT12\r\n";
  if (upper == "SN?") return "VIRTUAL1\r\n";
  if (upper == "CONNECTED?") return connected();
  const auto celsius = laboratory_.thermometers_as_measured_c();
  std::array<std::optional<double>, drivers::kPt12Inputs> shown;
  for (std::size_t i = 0; i < shown.size(); ++i)
    if (inputs_[i]) shown[i] = celsius[*inputs_[i]];
  if (upper == "T?") return drivers::encode_pt12_temperatures(shown) + "\r\n";
  if (const auto input = input_of(upper); input > 0)
    return drivers::encode_pt12_temperatures(std::span(shown).subspan(input - 1, 1)) + "\r\n";
  return {};
}

}  // namespace gyrotherm::simulator
