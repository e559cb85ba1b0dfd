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

/// Sets the time of each row since the first row, and its UTC if that is known. The clock advances only by accept(), so
/// a row that is left out does not change the times of later rows. The faults have no position.
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
  /// day, or if the time is more than ten years after the first row.
  [[nodiscard]] Result<void> read_clock(std::string_view clock, ForeignRow& row);
  /// Advances the clock to the row that was read last.
  void accept() { accepted_ = read_; }

 private:
  [[nodiscard]] CountedTime unwrap(const CountedTime& number);

  struct State {
    std::optional<CountedTime> first_number{}, last_number{};
    CountedTime wrapped{};  ///< sum of the wraps so far
    std::optional<Duration> first_utc{}, first_clock{}, last_clock{};
    Duration days{};
  };

  const ImportMap& map_;
  /// The states after the last accepted row and after the last row that was read.
  State accepted_{}, read_{};
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
