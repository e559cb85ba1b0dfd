// SPDX-License-Identifier: Apache-2.0
/// A map that is guessed of any bytes can be read, and is a map unless the file has no column to guess.
#include <cstddef>
#include <cstdint>
#include <string>

#include "acquisition/exchange/guess.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "tests/acquisition/exchange/fuzz.hpp"

namespace gyrotherm::exchange {

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string& table : {bytes, "time,gyro x,gyro y,T\n" + bytes, "t;T;w\n0;1;2\n" + bytes}) {
    const auto map = guess_map_of(table, "fuzz");
    if (map)
      require(parse_import_map(*map, "fuzz").has_value());
    else
      require(map.error().kind == FaultKind::bad_file && map.error().where.starts_with("fuzz"));
  }
  return 0;
}

}  // namespace gyrotherm::exchange
