// SPDX-License-Identifier: Apache-2.0
/// Parses times in files of other programs: numbers counted from an instant, and calendar times in ISO 8601, in
/// UDUNITS, and in the notations of common locales, loggers and spreadsheets.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/quantity.hpp"

namespace gyrotherm::exchange {

/// The longest time between two rows of an imported file: ten years.
inline constexpr Duration kLongestForeignTime = std::chrono::hours(24 * 3652);

/// A time since the file's own reference instant, with a wider range than Duration. Unlike a double it is exact: a
/// double that counts nanoseconds since 1970 has a resolution of 256 ns, and a difference of two such times has the
/// errors of both.
struct CountedTime {
  std::int64_t seconds{};
  Duration part{};  ///< less than one second
  bool operator==(const CountedTime&) const = default;
};

/// Returns a number of units as a time. A time outside the range of CountedTime becomes the nearest limit, which is
/// outside the range of a record.
[[nodiscard]] CountedTime counted_time(std::int64_t number, Duration unit);
[[nodiscard]] CountedTime counted_time(double number, Duration unit);

/// Parses a number with a decimal point, in multiples of `unit`, to the nearest nanosecond. Accepts the same texts as
/// record::number_in(), and returns nothing for any other text.
[[nodiscard]] std::optional<CountedTime> parse_counted_time(std::string_view text, Duration unit);

/// Returns the duration from `first` to `second`. Returns nothing if its magnitude exceeds kLongestForeignTime.
[[nodiscard]] std::optional<Duration> duration_between(const CountedTime& first, const CountedTime& second);

/// Converts a time since 1970 to UTC. Returns nothing if it is outside the range of a record.
[[nodiscard]] std::optional<Duration> to_utc(const CountedTime& since_1970);

[[nodiscard]] CountedTime operator+(const CountedTime& a, const CountedTime& b);

/// A calendar time, as a clock in some time zone shows it.
struct CivilTime {
  /// Time since 1970-01-01T00:00 on that clock.
  Duration reading{};
  /// The offset of the zone ahead of UTC, if known.
  std::optional<Duration> zone{};
};

/// Parses "2026-03-01T12:30:05.25Z", "2026-03-01 12:30:05,25+01:00", "2026-03-01T12:30", "2026-03-01". Returns nothing
/// for any other text and for a time outside 1970 to 2116.
[[nodiscard]] std::optional<CivilTime> parse_civil_time(std::string_view text);

/// Parses a text that is only a zone: "Z", "+01:00", "-0330", "+01". Returns nothing for any other text.
[[nodiscard]] std::optional<Duration> parse_zone(std::string_view text);

/// The calendar for dates before 1582-10-15.
enum class EarlyDays { julian, gregorian };

/// Parses the instant after "seconds since" in a NetCDF file, as UDUNITS does: "2026-03-01 12:00:00.5 -6:00",
/// "0001-1-1". The year is 0 to 9999. Numbers may have fewer digits than in ISO 8601. The zone is UTC unless the text
/// names another. Returns the time since 1970, or nothing for any other text.
[[nodiscard]] std::optional<CountedTime> parse_reference_time(std::string_view text, EarlyDays early);

/// The order of year, month and day in a numeric date.
enum class DateOrder { year_first, day_first, month_first };

/// Parses a date, or a date with its time of day and an optional zone: "01.03.2026 08:00:10,5", "3/1/26, 8:00:10 PM",
/// "2026/03/01 08:00", "1-Mar-2026 08:00:10", "20260301T080010Z", "Sun Mar  1 08:00:10 2026". A month may be a name in
/// English, German, French, Spanish or Italian; `order` is then ignored. A year of two digits is in 1970 to 2069.
/// Returns nothing for any other text and for a time outside 1970 to 2116.
[[nodiscard]] std::optional<CivilTime> parse_local_time(std::string_view text, DateOrder order);

/// Parses a text that is only a time of day: "08:00:10.5", "8:00:10 PM", "080010", "08h00". Returns nothing for any
/// other text.
[[nodiscard]] std::optional<Duration> parse_clock(std::string_view text);

/// Returns whether a text looks like a date or a time of day, even if no function of this file can parse it.
[[nodiscard]] bool looks_like_time(std::string_view text);

}  // namespace gyrotherm::exchange
