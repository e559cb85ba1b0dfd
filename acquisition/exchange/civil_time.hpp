// SPDX-License-Identifier: Apache-2.0
/// Times of the calendar as text, after ISO 8601: what tables of others say when a row was written.
#pragma once

#include <optional>
#include <string_view>

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

}  // namespace gyrotherm::exchange
