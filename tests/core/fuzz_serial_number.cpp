// SPDX-License-Identifier: Apache-2.0
/// Fuzzes serial numbers. Any text must be refused or yield a number that is valid by itself.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/serial_number.hpp"
#include "core/text.hpp"
#include "tests/support/fuzz_target.hpp"

FUZZ_TARGET(serial_number, const std::uint8_t* data, std::size_t size) {
  using gyrotherm::fuzz::require;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto number = gyrotherm::parse_serial_number(text);
  if (!number) {
    require(gyrotherm::plain(number.error().what) == number.error().what);
    return 0;
  }
  require(!number->empty() && number->size() <= gyrotherm::kLongestSerialNumber);
  require(gyrotherm::is_utf8(*number) && gyrotherm::plain(*number) == *number);
  require(text.find(*number) != std::string_view::npos);
  require(gyrotherm::parse_serial_number(*number) == *number);
  require(gyrotherm::contains_serial_number(*number, *number));
  (void)gyrotherm::contains_serial_number(text, text.substr(0, size / 2));
  return 0;
}
