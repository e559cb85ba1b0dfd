// SPDX-License-Identifier: Apache-2.0
/// The clocks of a text table. The clock that the map names gives the times of the rows; other clocks serve as a check.
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

/// Sets the time since the first row in each row, and UTC if it is known. Faults have no position.
class RowClock {
 public:
  explicit RowClock(const ImportMap& map) : map_(map) {}

  /// Takes the time from a number of the map's units, and from the `week` of GPS if the map has one. Continues when the
  /// counter wraps. Fails with bad_file more than ten years after the first row, or if UTC is outside 1970 to 2116.
  [[nodiscard]] Result<void> read_number(const CountedTime& number, std::optional<double> week, ForeignRow& row);
  /// Takes the time from a date with its time of day, or from two separate texts. Fails with bad_file if the texts are
  /// not a time, or if neither they nor the map name a zone.
  [[nodiscard]] Result<void> read_date(std::string_view date, std::string_view clock, ForeignRow& row);
  /// Takes the time from a time of day, which restarts at midnight. Fails with bad_file if the text is not a time of
  /// day.
  [[nodiscard]] Result<void> read_clock(std::string_view clock, ForeignRow& row);

 private:
  [[nodiscard]] CountedTime unwrapped(const CountedTime& number);

  const ImportMap& map_;
  std::optional<CountedTime> first_number_{}, last_number_{};
  CountedTime wrapped_{};  ///< sum of the wraps so far
  std::optional<Duration> first_utc_{}, first_clock_{}, last_clock_{};
  Duration days_{};
};

/// Columns with dates or times of day that the map does not name. They verify the map's time: a table has the same
/// duration by all of its clocks.
class OtherClocks {
 public:
  struct Clock {
    std::size_t column{};
    std::string name{}, first{}, last{};
  };
  /// Keeps a column if its first text is a time. Keeps the first four such columns.
  void begin(std::size_t column, const std::string& name, std::string_view first);
  [[nodiscard]] std::vector<Clock>& clocks() { return clocks_; }
  /// Puts the first clock that advances into the findings.
  void report(Findings& findings) const;

 private:
  std::vector<Clock> clocks_{};
};

}  // namespace gyrotherm::exchange
