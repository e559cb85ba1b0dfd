// SPDX-License-Identifier: Apache-2.0
/// Times of the calendar as text, after ISO 8601: what tables of others say when a row was written.
#pragma once

#include <optional>
#include <string_view>

#include "acquisition/exchange/counted_time.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::exchange {

struct CivilTime {
  Duration reading{};              ///< since 1970-01-01T00:00 as a clock of that zone shows it
  std::optional<Duration> zone{};  ///< how far its clocks are ahead of UTC, where the text says so
};

/// Reads "2026-03-01T12:30:05.25Z", "2026-03-01 12:30:05,25+01:00", "2026-03-01T12:30", "2026-03-01". Nothing if it is
/// none, or lies outside 1970 to 2116.
[[nodiscard]] std::optional<CivilTime> parse_civil_time(std::string_view text);

/// Reads a zone alone: "Z", "+01:00", "-0330", "+01".
[[nodiscard]] std::optional<Duration> parse_zone(std::string_view text);

/// How days before 1582-10-15 are called: as they were then, after the Julian calendar, or after the one of today.
enum class EarlyDays { julian, gregorian };

/// Reads what stands behind "seconds since" in a NetCDF file: "2026-03-01 12:00:00.5 -6:00", "0001-1-1", after UDUNITS:
/// of any year from 0 to 9999, each field but the year's may have one digit, and the zone is UTC where none is named.
/// The time is counted from 1970.
[[nodiscard]] std::optional<CountedTime> parse_reference_time(std::string_view text, EarlyDays early);

}  // namespace gyrotherm::exchange
