// SPDX-License-Identifier: Apache-2.0
/// Parses any bytes as an import map. The result is a map or a fault, never a crash.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "acquisition/exchange/import_map.hpp"
#include "tests/support/fuzz_target.hpp"

FUZZ_TARGET(import_map, const std::uint8_t* data, std::size_t size) {
  const auto map = gyrotherm::exchange::parse_import_map({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!map && map.error().kind != gyrotherm::FaultKind::bad_file) std::abort();
  return 0;
}
