// SPDX-License-Identifier: Apache-2.0
/// Times of the calendar as the world's locales, loggers and spreadsheets write them.
#pragma once

#include <optional>
#include <string_view>

#include "acquisition/exchange/civil_time.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::exchange {

/// The order of the numbers of a date.
enum class DateOrder { year_first, day_first, month_first };

/// Reads a date, or a date with its time of day and perhaps a zone: "01.03.2026 08:00:10,5", "3/1/26, 8:00:10 PM",
/// "2026/03/01 08:00", "1-Mar-2026 08:00:10", "20260301T080010Z", "Sun Mar  1 08:00:10 2026". A month may be a name in
/// English, German, French, Spanish or Italian; then `order` does not count. A year of two digits lies in 1970 to 2069.
/// Nothing if it is none, or lies outside 1970 to 2116.
[[nodiscard]] std::optional<CivilTime> parse_local_time(std::string_view text, DateOrder order);

/// Reads a time of day alone: "08:00:10.5", "8:00:10 PM", "080010", "08h00". Nothing if it is none.
[[nodiscard]] std::optional<Duration> parse_clock(std::string_view text);

/// Whether people would take the text for a date or a time of day, whatever it is.
[[nodiscard]] bool looks_like_time(std::string_view text);

}  // namespace gyrotherm::exchange
