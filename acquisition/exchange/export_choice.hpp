// SPDX-License-Identifier: Apache-2.0
/// Selects the data of a record to export: some of its rows or means over stretches, with columns in °C and °/h.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Selects rows of a record.
struct ExportChoice {
  /// The first and last time to export, since the start of the run, both inclusive. If one is not set, the selection
  /// extends to that end of the record.
  std::optional<Duration> from{}, to{};
  /// The length of the stretches over which means are taken. 0 selects every row.
  Duration every{};
};

/// Parses a moment of a run: a time since its start ("2 h 30 min") or, if the record has a start time in UTC, a
/// calendar time with its zone ("2026-03-01T12:00:00Z"). `option` is the name of the option in a fault. Fails with
/// usage.
[[nodiscard]] Result<Duration> parse_moment(const std::string& text, const record::RunInfo& info,
                                            const std::string& option);

/// Fails with usage if `every` is negative or not a whole number of seconds of the record, or if `from` is after `to`.
[[nodiscard]] Result<void> check_choice(const ExportChoice& choice, const record::RunInfo& info);

/// Returns the selected rows; the unchanged record if every row is selected. Stretches are counted from the start of
/// the run. The row of a stretch has the time and the profile position of the first row in the stretch, the means of
/// temperatures, rates and values, and the sums of pulses and intervals. The sum of an axis is missing if its pulses
/// are missing in any second that has an interval. Events and gaps remain unchanged.
[[nodiscard]] record::Record chosen_rows(record::Record record, const ExportChoice& choice);

/// Returns the calibrated temperatures of a thermometer in °C; NaN if there was no reading.
[[nodiscard]] std::vector<double> calibrated_temperatures(const record::Record& record, std::size_t thermometer);

/// Returns the rate about an axis in °/h, including the Earth rate; NaN if there is none.
[[nodiscard]] std::vector<double> axis_rates(const record::Record& record, std::size_t unit, std::size_t axis);

}  // namespace gyrotherm::exchange
