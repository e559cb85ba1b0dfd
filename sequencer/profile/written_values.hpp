/// The values a profile is written in: read from a table, in the ranges that make sense. Every value outside is noted
/// as a mistake.
#pragma once

#include <optional>
#include <string_view>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "sequencer/profile/written_profile.hpp"

namespace gyrotherm {

/// Longer than zero; rounded up to whole seconds.
[[nodiscard]] Duration read_time(const TomlTable& table, std::string_view key);
[[nodiscard]] std::optional<Duration> read_time_if_any(const TomlTable& table, std::string_view key);

/// From absolute zero to 1000 °C.
[[nodiscard]] Celsius read_temperature(const TomlTable& table, std::string_view key);
[[nodiscard]] std::optional<Celsius> read_temperature_if_any(const TomlTable& table, std::string_view key);

/// More than 0, at most 1000 °C/min.
[[nodiscard]] std::optional<CelsiusPerMinute> read_rate_if_any(const TomlTable& table, std::string_view key);
[[nodiscard]] std::vector<CelsiusPerMinute> read_rates(const TomlTable& table, std::string_view key);

/// More than 0 K.
[[nodiscard]] Kelvins read_band(const TomlTable& table, std::string_view key, Kelvins fallback);

/// Two rates or times, the first not above the second.
[[nodiscard]] WrittenRange<CelsiusPerMinute> read_rate_range(const TomlTable& table, std::string_view key);
[[nodiscard]] WrittenRange<Duration> read_time_range(const TomlTable& table, std::string_view key);

/// Rows of two temperatures, the first not above the second; at least one row.
[[nodiscard]] std::vector<WrittenRange<Celsius>> read_temperature_ranges(const TomlTable& table, std::string_view key);

}  // namespace gyrotherm
