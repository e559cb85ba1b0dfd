// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the output of a thermometer program with any text. A decoded text must be a greeting or possible
/// temperatures.
#include <cstdlib>

#include "core/text.hpp"
#include "drivers/thermometer/process_thermometer.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

using fuzz::require;
namespace {

void take(std::string_view text) {
  if (const auto line = split_numbered_line(text)) require(line->rest.size() <= text.size());
  if (const auto greeting = decode_process_greeting(text)) {
    require(greeting->inputs >= 1 && greeting->inputs <= kMostProcessInputs && is_utf8(greeting->identity));
    require(decode_process_greeting(encode_process_greeting(*greeting)).value() == *greeting);
  }
  for (const std::size_t inputs : {1, 2, 8}) {
    const auto readings = decode_process_readings(text, inputs);
    if (!readings) continue;
    require(readings->size() == inputs);
    for (const auto& reading : *readings) require(!reading || (reading->value >= -273.15 && reading->value <= 3000));
  }
}

}  // namespace

FUZZ_TARGET(process_thermometer, const std::uint8_t* data, std::size_t size) {
  const std::string line(reinterpret_cast<const char*>(data), size);
  take(line);
  take("gyrotherm-thermometer/1 " + line);
  // Repeats the test with the bytes mapped to the characters of readings.
  std::string numbers;
  for (const char byte : line) numbers += "    .. -+e0123456789 -123456789"[byte & 31];
  take(numbers);
  return 0;
}

}  // namespace gyrotherm::drivers
