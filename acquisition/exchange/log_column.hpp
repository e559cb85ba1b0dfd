// SPDX-License-Identifier: Apache-2.0
/// Columns of autopilots' logs: numbers in messages of many kinds, each with its own bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::exchange {

/// A field of a message, of which a log may have several series: those of one sensor each.
struct LogColumn {
  std::string message;
  unsigned instance{};
  std::string field;
};

/// Reads "sensor_gyro.x" or "sensor_gyro[1].x"; nothing if it is no such name.
[[nodiscard]] std::optional<LogColumn> parse_log_column(std::string_view name);
/// "sensor_gyro", "sensor_gyro[1]".
[[nodiscard]] std::string name_of_series(std::string_view message, unsigned instance);

/// How a number stands in a message; the least significant byte comes first.
enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float16, float32, float64 };
[[nodiscard]] std::size_t size_of(NumberType type);
/// The number at a place of a message that has it whole; NaN for what is infinite, too.
[[nodiscard]] double number_at(std::string_view message, std::size_t place, NumberType type);
[[nodiscard]] std::uint64_t whole_number_at(std::string_view message, std::size_t place, std::size_t bytes);

/// Says which columns a log has not, and what it has instead: the fields of the message, or the messages.
[[nodiscard]] std::string describe_missing_log_columns(const std::vector<LogColumn>& missing,
                                                       const std::vector<LogColumn>& there);

}  // namespace gyrotherm::exchange
