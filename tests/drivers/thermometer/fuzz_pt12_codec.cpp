// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the answers of a PT12 with any text. Decoded readings must be possible temperatures.
#include <cstdlib>

#include "drivers/thermometer/pt12.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

FUZZ_TARGET(pt12_codec, const std::uint8_t* data, std::size_t size) {
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  const auto check = [](const Result<Celsius>& reading) {
    if (reading && !(reading->value >= -200 && reading->value <= 850)) std::abort();
  };
  const auto decode_all = [&](std::string_view text) {
    if (const auto readings = decode_pt12_temperatures(text)) {
      if (readings->size() != kPt12Inputs) std::abort();
      for (const auto& reading : *readings) check(reading);
    }
  };
  decode_all(line);
  // Repeats the test with the bytes mapped to the characters of readings.
  std::string numbers;
  for (const char byte : line) numbers += ",,,. -+e0123456789NaN, 12345678"[byte & 31];
  decode_all(numbers);
  return 0;
}

}  // namespace gyrotherm::drivers
