// SPDX-License-Identifier: Apache-2.0
/// Times in foreign files: counted from an instant, or of the calendar after ISO 8601, after UDUNITS, and as the
/// world's locales, loggers and spreadsheets write them.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/quantity.hpp"

namespace gyrotherm::exchange {

/// The longest time between two rows of a foreign file that a record can have: ten years.
inline constexpr Duration kLongestForeignTime = std::chrono::hours(24 * 3652);

/// A time that a file counts in units from an instant of its own. It has a wider range than a Duration. A double of
/// nanoseconds since 1970 keeps only every 256th, and a difference of two has the errors of both: this one is exact.
struct CountedTime {
  std::int64_t seconds{};
  Duration part{};  ///< fraction of the next second
  bool operator==(const CountedTime&) const = default;
};

/// Returns a number of units as a time. A time outside the range becomes its limit, which no record can have.
[[nodiscard]] CountedTime counted_time(std::int64_t number, Duration unit);
[[nodiscard]] CountedTime counted_time(double number, Duration unit);

/// Parses a number with a decimal point, to the nearest nanosecond. Accepts the texts that record::number_in() does and
/// returns nothing for any other.
[[nodiscard]] std::optional<CountedTime> parse_counted_time(std::string_view text, Duration unit);

/// Returns the time from the first to the second. Returns nothing if its magnitude exceeds kLongestForeignTime.
[[nodiscard]] std::optional<Duration> between(const CountedTime& first, const CountedTime& second);

/// Returns the UTC of a time since 1970, or nothing if no record can have it.
[[nodiscard]] std::optional<Duration> utc_of(const CountedTime& since_1970);

[[nodiscard]] CountedTime operator+(const CountedTime& a, const CountedTime& b);

/// A time of the calendar, as a clock of a zone shows it.
struct CivilTime {
  Duration reading{};              ///< since 1970-01-01T00:00 of that clock
  std::optional<Duration> zone{};  ///< ahead of UTC, if known
};

/// Parses "2026-03-01T12:30:05.25Z", "2026-03-01 12:30:05,25+01:00", "2026-03-01T12:30", "2026-03-01". Returns nothing
/// for any other text and for a time outside 1970 to 2116.
[[nodiscard]] std::optional<CivilTime> parse_civil_time(std::string_view text);

/// Parses a zone alone: "Z", "+01:00", "-0330", "+01". Returns nothing for any other text.
[[nodiscard]] std::optional<Duration> parse_zone(std::string_view text);

/// The calendar of days before 1582-10-15.
enum class EarlyDays { julian, gregorian };

/// Parses the instant behind "seconds since" in a NetCDF file, after UDUNITS: "2026-03-01 12:00:00.5 -6:00",
/// "0001-1-1". The year is 0 to 9999, each field may have fewer digits, and the zone is UTC unless the text names
/// another. Returns the time since 1970, or nothing for any other text.
[[nodiscard]] std::optional<CountedTime> parse_reference_time(std::string_view text, EarlyDays early);

/// The order of the numbers of a date.
enum class DateOrder { year_first, day_first, month_first };

/// Parses a date, or a date with its time of day and perhaps a zone: "01.03.2026 08:00:10,5", "3/1/26, 8:00:10 PM",
/// "2026/03/01 08:00", "1-Mar-2026 08:00:10", "20260301T080010Z", "Sun Mar  1 08:00:10 2026". A month may be a name in
/// English, German, French, Spanish or Italian; then `order` does not count. A year of two digits lies in 1970 to 2069.
/// Returns nothing for any other text and for a time outside 1970 to 2116.
[[nodiscard]] std::optional<CivilTime> parse_local_time(std::string_view text, DateOrder order);

/// Parses a time of day alone: "08:00:10.5", "8:00:10 PM", "080010", "08h00". Returns nothing for any other text.
[[nodiscard]] std::optional<Duration> parse_clock(std::string_view text);

/// Returns true if people would take the text for a date or a time of day, even one that no function here parses.
[[nodiscard]] bool looks_like_time(std::string_view text);

}  // namespace gyrotherm::exchange
