// SPDX-License-Identifier: Apache-2.0
/// Times that a foreign file counts in units from an instant of its own. Of nanoseconds since 1970 a double keeps only
/// every 256th, and a difference of two such doubles has the error of both: here they stay whole numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/quantity.hpp"

namespace gyrotherm::exchange {

/// How long after the instant from which a file counts; it reaches further than a Duration does.
struct CountedTime {
  std::int64_t seconds{};
  Duration part{};  ///< of the next second
  bool operator==(const CountedTime&) const = default;
};

/// So many units. Beyond what can be told, which no record can have, it is the longest time that can.
[[nodiscard]] CountedTime counted_time(std::int64_t number, Duration unit);
[[nodiscard]] CountedTime counted_time(double number, Duration unit);

/// What a number says that is written with a decimal point, to the nearest nanosecond, as record::number_in() takes
/// them. Nothing if it is none.
[[nodiscard]] std::optional<CountedTime> parse_counted_time(std::string_view text, Duration unit);

/// How much later the second is; nothing if that, or the opposite, is longer than kLongestForeignTime.
[[nodiscard]] std::optional<Duration> between(const CountedTime& first, const CountedTime& second);

/// The UTC of a time that is counted from 1970; nothing if a record cannot have it.
[[nodiscard]] std::optional<Duration> utc_of(const CountedTime& since_1970);

[[nodiscard]] CountedTime operator+(const CountedTime& a, const CountedTime& b);

}  // namespace gyrotherm::exchange
