// SPDX-License-Identifier: Apache-2.0
/// Requirement for every reader of foreign files. For any bytes it returns either rows with increasing times and with
/// finite or missing numbers, or a fault with its position in the file.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "acquisition/exchange/import.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {

using fuzz::require;

inline void require_rows_or_a_fault(const std::string& bytes, const ImportMap& map) {
  std::optional<Duration> last;
  const auto read = read_foreign_text(bytes, "fuzz", map, [&](const ImportedRow& row) -> Result<void> {
    require(row.time >= Duration{} && (!last || row.time > *last));
    for (const double number : row.numbers) require(!std::isinf(number));
    last = row.time;
    return {};
  });
  if (read) return require(last.has_value());
  require(read.error().kind == FaultKind::bad_file && read.error().where.starts_with("fuzz"));
}

}  // namespace gyrotherm::exchange
