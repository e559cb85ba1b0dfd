/// What a certificate makes of a thermometer's readings. Dates are days of UTC.
#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"

namespace gyrotherm {

/// The temperature that a reading stands for: reading + offset, or Σ c_i reading^i (both in °C) where the channel has a
/// polynomial.
[[nodiscard]] Celsius calibrated(const Channel& channel, Celsius reading);

/// "2027-03-01"; nothing if there is no such day.
[[nodiscard]] std::optional<std::chrono::sys_days> parse_day(std::string_view text);
[[nodiscard]] std::string day_text(std::chrono::sys_days day);

/// "offset 0.01 K, certificate 2026-0123, due 2027-03-01"; "none" without any.
[[nodiscard]] std::string calibration_in_words(const Channel& channel);

/// Of each channel whose calibration was due before `utc`: "calibration of A (certificate 2026-0123) was due
/// 2027-03-01".
[[nodiscard]] std::vector<std::string> overdue_calibrations(std::span<const Channel> channels, Duration utc);

}  // namespace gyrotherm
