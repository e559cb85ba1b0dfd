// SPDX-License-Identifier: Apache-2.0
/// Fuzzes DCON answers with any text, with and without a checksum. Decoded readings must be possible temperatures.
#include <cstdlib>

#include "drivers/thermometer/dcon_thermometer.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

FUZZ_TARGET(dcon_codec, const std::uint8_t* data, std::size_t size) {
  static const std::vector<TemperatureRange> ranges(kDconInputs, TemperatureRange{{-100}, {400}});
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  const auto try_readings = [&](std::string_view text, std::size_t inputs) {
    const auto readings = decode_dcon_readings(text, 4, std::span(ranges).first(inputs));
    if (!readings) return;
    if (readings->size() != inputs) std::abort();
    for (const auto& reading : *readings)
      if (reading && !(reading->value >= -100 && reading->value <= 400)) std::abort();
  };
  try_readings(line, kDconInputs);
  try_readings(line, 1);
  if (const auto text = unseal_dcon(line, DconChecksum::on)) {
    try_readings(*text, kDconInputs);
    if (seal_dcon(std::string(*text), DconChecksum::on) != line) std::abort();
  }
  // Repeats the test with the bytes mapped to the characters of readings.
  std::string values = ">";
  for (const char byte : line) values += "+-.0123456789+-0"[byte & 15];
  try_readings(values, kDconInputs);
  try_readings(values, 1);
  if (unseal_dcon(seal_dcon(values, DconChecksum::on), DconChecksum::on) != std::string_view(values)) std::abort();

  if (const auto rest = decode_dcon_answer(line, 4)) (void)decode_dcon_type(*rest, 0);
  if (const auto configuration = decode_dcon_configuration(line))
    if (encode_dcon_configuration(*configuration) != line) std::abort();
  return 0;
}

}  // namespace gyrotherm::drivers
