// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the replies of a Lake Shore 218 with any text. Decoded replies must be eight possible temperatures.
#include <cstdlib>

#include "drivers/thermometer/lakeshore_218.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

FUZZ_TARGET(lakeshore_218_codec, const std::uint8_t* data, std::size_t size) {
  const auto readings = decode_crdg({reinterpret_cast<const char*>(data), size});
  if (!readings) return 0;
  if (readings->size() != kLakeshore218Inputs) std::abort();
  for (const auto& reading : *readings)
    if (reading && !(reading->value >= -273.15 && reading->value <= 1000)) std::abort();
  return 0;
}

}  // namespace gyrotherm::drivers
