// SPDX-License-Identifier: Apache-2.0
#include "drivers/virtual_identity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace gyrotherm::drivers {
namespace {

/// The beginnings of the identities of the shipped virtual chambers. The number is read from the chamber.
constexpr std::array<std::string_view, 3> kVirtualChambers{"gyrotherm virtual chamber (identity = 21868)",
                                                           "gyrotherm virtual climate chamber (identity = 21868)",
                                                           "gyrotherm virtual chamber with limiter (identity = 21869)"};

bool continues_serial(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' || c == '_' || c == '.';
}

bool contains_token(std::string_view text, std::string_view token) {
  for (auto at = text.find(token); at != std::string_view::npos; at = text.find(token, at + 1)) {
    const auto end = at + token.size();
    const bool is_begin = at == 0 || !continues_serial(text[at - 1]);
    if (is_begin && (end == text.size() || !continues_serial(text[end]))) return true;
  }
  return false;
}

}  // namespace

bool is_virtual_identity(std::string_view identity) {
  return contains_token(identity, kVirtualSerialNumber) || contains_token(identity, kShortVirtualName) ||
         contains_token(identity, fmt::format("serial_number = {}", kVirtualSerialInteger)) ||
         std::ranges::any_of(kVirtualChambers, [&](auto chamber) { return identity.starts_with(chamber); });
}

std::string add_virtual_mark(const std::string& identity) {
  if (is_virtual_identity(identity)) return identity;
  return fmt::format("{}{}{}", identity, identity.find(',') == std::string::npos ? " " : ",", kVirtualSerialNumber);
}

}  // namespace gyrotherm::drivers
