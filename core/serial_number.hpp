// SPDX-License-Identifier: Apache-2.0
/// Serial numbers of units under test, as people type them and bar-code readers send them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

/// Longest serial number, in bytes.
inline constexpr std::size_t kLongestSerialNumber = 64;

/// Returns the serial number in `text`, without blanks, tabs and line ends at its start and end. Leading zeros, the
/// case of letters and blanks inside are kept: "0042" and "42" are different numbers. Fails with usage if the number is
/// empty or too long, is not UTF-8, or contains a control character or a mark of writing direction.
[[nodiscard]] Result<std::string> parse_serial_number(std::string_view text);

/// Returns whether `identity`, the answer of an instrument, contains the serial number as a token of its own. Leading
/// zeros are ignored, because an instrument may send its number as a binary value: "SN 0042", "SN42" and "SN 00042"
/// contain "0042", but "SN 10042" and "SN 00421" do not.
[[nodiscard]] bool contains_serial_number(std::string_view identity, std::string_view serial_number);

}  // namespace gyrotherm
