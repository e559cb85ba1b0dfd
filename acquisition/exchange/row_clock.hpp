// SPDX-License-Identifier: Apache-2.0
/// When the rows of a text table were written, by what their cells say and by the map.
#pragma once

#include <optional>
#include <string_view>

#include "acquisition/exchange/counted_time.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

class RowClock {
 public:
  explicit RowClock(const ImportMap& map) : map_(map) {}

  // Each puts the time since the first row, and the UTC where it is known, into a row. Faults have no place.

  /// From a number of the map's units; `week` of GPS where the map has one. Carries on where the counter wraps. Fails
  /// with bad_file more than ten years after the first row, or where UTC is outside of 1970 to 2116.
  [[nodiscard]] Result<void> read_number(const CountedTime& number, std::optional<double> week, ForeignRow& row);
  /// From a date with its time of day, or from the two of them apart. Fails with bad_file where they are none, or name
  /// no zone and the map neither.
  [[nodiscard]] Result<void> read_date(std::string_view date, std::string_view clock, ForeignRow& row);
  /// From a time of day, which begins anew at midnight.
  [[nodiscard]] Result<void> read_clock(std::string_view clock, ForeignRow& row);

 private:
  [[nodiscard]] CountedTime unwrapped(const CountedTime& number);

  const ImportMap& map_;
  std::optional<CountedTime> first_number_{}, last_number_{};
  CountedTime wrapped_{};  ///< what the wraps so far come to
  std::optional<Duration> first_utc_{}, first_clock_{}, last_clock_{};
  Duration days_{};
};

}  // namespace gyrotherm::exchange
