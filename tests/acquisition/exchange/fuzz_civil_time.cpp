// SPDX-License-Identifier: Apache-2.0
/// Parses any bytes as a calendar time. A parsed time must be in the range that a record can represent.
#include <cstddef>
#include <cstdint>
#include <string>

#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/record/row.hpp"
#include "tests/acquisition/exchange/fuzz.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {

FUZZ_TARGET(civil_time, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string& text : {bytes, "2026-03-01T12:30" + bytes, "2026-03-01 " + bytes, "2026-" + bytes}) {
    for (const auto early : {EarlyDays::julian, EarlyDays::gregorian})
      if (const auto reference = parse_reference_time(text, early))
        require(reference->part >= Duration{} && reference->part < kSecond);
    const auto time = parse_civil_time(text);
    if (!time) continue;
    require(time->reading >= Duration{});
    if (time->zone) require(record::is_possible_time(time->reading - *time->zone));
  }
  return 0;
}

}  // namespace gyrotherm::exchange
