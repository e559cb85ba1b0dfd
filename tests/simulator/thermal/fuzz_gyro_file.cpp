// SPDX-License-Identifier: Apache-2.0
/// Parses any text as a gyro file. The result must be a consistent gyro or a fault with a position.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "simulator/thermal/gyro_model.hpp"
#include "tests/support/fuzz_target.hpp"

namespace {

using gyrotherm::fuzz::require;

const std::string& shipped() {
  static const std::string text = [] {
    std::ifstream file(GYROTHERM_SOURCE_DIR "/profiles/gyros/calibrated.toml");
    std::ostringstream all;
    all << file.rdbuf();
    return all.str();
  }();
  return text;
}

void run(const std::string& text) {
  const auto model = gyrotherm::thermal::parse_gyro(text, "fuzz.toml");
  if (!model) return require(model.error().where.starts_with("fuzz.toml"));
  require(model->geometry.block_thickness > 0 && model->air.lid.width_m > 0);
  for (const double watts : model->powers_w) require(watts >= 0);
}

}  // namespace

FUZZ_TARGET(gyro_file, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  run(bytes);
  // Parses few whole gyros, because each takes longer.
  if (size < 4 || data[2] % 16 != 0) return 0;
  auto text = shipped();
  require(!text.empty());
  const std::size_t at = (data[0] * 256U + data[1]) % text.size();
  run(text.replace(at, std::min<std::size_t>(size - 3, text.size() - at), bytes.substr(3)));
  return 0;
}
