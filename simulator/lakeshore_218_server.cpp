#include "simulator/lakeshore_218_server.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kLongestCommand = 64;
constexpr double kZeroCelsiusInKelvin = 273.15;
constexpr int kDecimals = 3;

std::string_view without_blanks(std::string_view text) {
  const auto first = text.find_first_not_of(" \r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \r") - first + 1);
}

}  // namespace

bool Lakeshore218Session::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  for (const auto byte : bytes) {
    const char character = static_cast<char>(byte);
    if (character != '\n') {
      if (line_.size() < kLongestCommand)
        line_.push_back(character);
      else
        line_too_long_ = true;
      continue;
    }
    const auto text = line_too_long_ ? std::string{} : answer(without_blanks(line_));
    const auto answered = std::as_bytes(std::span(text));
    reply.insert(reply.end(), answered.begin(), answered.end());
    line_.clear();
    line_too_long_ = false;
  }
  return true;
}

std::string Lakeshore218Session::answer(std::string_view command) const {
  if (command == "*IDN?") return "LSCI,MODEL218S,VIRTUAL1,010126\r\n";
  if (command.starts_with("CRDG?")) return readings(without_blanks(command.substr(5)), 0);
  if (command.starts_with("KRDG?")) return readings(without_blanks(command.substr(5)), kZeroCelsiusInKelvin);
  return {};
}

std::string Lakeshore218Session::readings(std::string_view argument, double zero_c) const {
  const auto celsius = world_.thermometers_as_measured_c();
  std::array<double, kLakeshore218Inputs> shown{};
  for (std::size_t i = 0; i < shown.size(); ++i) {
    shown[i] = (inputs_[i] ? celsius[*inputs_[i]] : -kZeroCelsiusInKelvin) + zero_c;
  }
  if (argument.empty() || argument == "0") return encode_crdg(shown, kDecimals) + "\r\n";
  const bool one_input = argument.size() == 1 && argument[0] >= '1' && argument[0] <= '8';
  if (!one_input) return {};
  return encode_crdg(std::span(shown).subspan(static_cast<std::size_t>(argument[0] - '1'), 1), kDecimals) + "\r\n";
}

}  // namespace gyrotherm
