// SPDX-License-Identifier: Apache-2.0
/// Drafts a map for any bytes. The map must be valid or contain a question for the user.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "acquisition/exchange/guess.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "tests/acquisition/exchange/fuzz.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {

/// Returns whether the map is valid or has a question for the user in its invalid section.
bool is_valid_or_has_question(const std::string& map) {
  const auto read = parse_import_map(map, "fuzz");
  if (read) return true;
  constexpr std::string_view kPlace = "fuzz:";
  const auto& where = text(read.error());
  if (!where.starts_with(kPlace)) return false;
  std::size_t begin = 0;
  for (int line = std::atoi(where.c_str() + kPlace.size()); line > 1; --line) begin = map.find('\n', begin) + 1;
  const auto section = map.substr(begin, map.find("\n\n", begin) - begin);
  return section.find('?') != std::string::npos;
}

FUZZ_TARGET(guess, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string& table : {bytes, "time,gyro x,gyro y,T\n" + bytes, "t;T;w\n0;1;2\n" + bytes}) {
    const auto map = guess_map_from_bytes(table, "fuzz");
    if (map)
      require(is_valid_or_has_question(*map));
    else
      require(map.error().kind == FaultKind::bad_file && map.error().where.starts_with("fuzz"));
  }
  return 0;
}

}  // namespace gyrotherm::exchange
