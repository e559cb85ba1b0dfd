// SPDX-License-Identifier: Apache-2.0
/// Explains the usual slips in a number that a person has typed.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm {

/// Returns how to write the number in `text`, if one of these is the cause for refusing it: a minus sign that is not
/// the ASCII character, a decimal comma, degrees Fahrenheit, or a unit of time that is spelt out. Returns an empty text
/// otherwise.
[[nodiscard]] std::string hint_at_number(std::string_view text);

}  // namespace gyrotherm
