// SPDX-License-Identifier: Apache-2.0
#include "core/serial_number.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/text.hpp"

namespace gyrotherm {
namespace {

constexpr const char* kWhere = "serial number";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

std::string_view without_leading_zeros(std::string_view number) {
  return number.substr(std::min(number.find_first_not_of('0'), number.size() - 1));
}

/// Returns whether a token begins with `first` after the text `before`. A change from letters to digits, as in "SN42",
/// begins a token.
bool begins_token(std::string_view before, char first) {
  if (is_digit(first)) before = before.substr(0, before.find_last_not_of('0') + 1);
  if (before.empty()) return true;
  return !(is_digit(before.back()) && is_digit(first)) && !(is_letter(before.back()) && is_letter(first));
}

/// Returns the first character that a serial number cannot contain, escaped, with its position; empty if there is none.
std::string find_control_character(std::string_view text) {
  std::size_t position = 1;
  for (std::string_view left = text; !left.empty(); ++position) {
    const auto character = left.substr(0, std::max<std::size_t>(character_size(left), 1));
    if (const auto shown = plain(character); shown != character)
      return fmt::format("the character {} at position {}", shown, position);
    left.remove_prefix(character.size());
  }
  return {};
}

}  // namespace

Result<std::string> parse_serial_number(std::string_view text) {
  const auto number = trimmed(text, " \t\r\n");
  if (number.empty()) return failure(FaultKind::usage, kWhere, "is empty");
  if (number.size() > kLongestSerialNumber)
    return failure(FaultKind::usage, kWhere,
                   fmt::format("has {} bytes, expected at most {}: \"{}…\"", number.size(), kLongestSerialNumber,
                               plain(number.substr(0, kLongestSerialNumber / 2))));
  if (const auto control = find_control_character(number); !control.empty())
    return failure(FaultKind::usage, kWhere,
                   fmt::format("\"{}\" contains {}; set the bar-code reader to send only the number and Enter",
                               plain(number), control));
  return std::string(number);
}

bool contains_serial_number(std::string_view identity, std::string_view serial_number) {
  if (serial_number.empty()) return false;
  const auto number = without_leading_zeros(serial_number);
  for (auto at = identity.find(number); at != std::string_view::npos; at = identity.find(number, at + 1)) {
    const auto end = at + number.size();
    const bool ends = end == identity.size() || !(is_digit(identity[end]) || is_letter(identity[end]));
    if (ends && begins_token(identity.substr(0, at), number.front())) return true;
  }
  return false;
}

}  // namespace gyrotherm
