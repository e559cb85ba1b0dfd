// SPDX-License-Identifier: Apache-2.0
/// The clocks of a text table. The clock that the map names determines the times of the rows. Other clocks are used to
/// check it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Sets the time of each row since the first row, and its UTC if that is known. The faults have no position.
class RowClock {
 public:
  explicit RowClock(const ImportMap& map) : map_(map) {}

  /// Computes the time from a number in the map's unit, and from the GPS `week` if the map has one. The time continues
  /// to increase when the counter wraps. Fails with bad_file if the time is more than ten years after the first row, or
  /// if UTC is outside 1970 to 2116.
  [[nodiscard]] Result<void> read_number(const CountedTime& number, std::optional<double> week, ForeignRow& row);
  /// Computes the time from a date and a time of day, in one text or in two. Fails with bad_file if the texts are not a
  /// time, or if neither the texts nor the map name a zone.
  [[nodiscard]] Result<void> read_date(std::string_view date, std::string_view clock, ForeignRow& row);
  /// Computes the time from a time of day, which restarts at midnight. Fails with bad_file if the text is not a time of
  /// day.
  [[nodiscard]] Result<void> read_clock(std::string_view clock, ForeignRow& row);

 private:
  [[nodiscard]] CountedTime unwrap(const CountedTime& number);

  const ImportMap& map_;
  std::optional<CountedTime> first_number_{}, last_number_{};
  CountedTime wrapped_{};  ///< sum of the wraps so far
  std::optional<Duration> first_utc_{}, first_clock_{}, last_clock_{};
  Duration days_{};
};

/// Columns with dates or times of day that the map does not name. They are used to check the map's time: all clocks of
/// a table must show the same duration.
class OtherClocks {
 public:
  struct Clock {
    std::size_t column{};
    std::string name{}, first{}, last{};
  };
  /// Keeps a column if its first text is a time. Keeps the first four such columns.
  void begin(std::size_t column, const std::string& name, std::string_view first);
  [[nodiscard]] std::vector<Clock>& clocks() { return clocks_; }
  /// Adds the name and the possible durations of the first clock that advances to the findings.
  void report(Findings& findings) const;

 private:
  std::vector<Clock> clocks_{};
};

}  // namespace gyrotherm::exchange
