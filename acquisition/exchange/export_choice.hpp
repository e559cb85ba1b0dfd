// SPDX-License-Identifier: Apache-2.0
/// Which rows of a record are exported: a part of it, or means over stretches.
#pragma once

#include <optional>
#include <string>

#include "acquisition/record/record.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

struct ExportChoice {
  std::optional<Duration> from{}, to{};  ///< since the start, both included; nothing: to that end of the record
  Duration every{};                      ///< means over stretches of this length; 0: every row
};

/// What people say for a moment of a run: a time since its start ("2 h 30 min") or, where the record knows UTC, a time
/// of the calendar with its zone ("2026-03-01T12:00:00Z"). `option` names it in a fault. Fails with usage.
[[nodiscard]] Result<Duration> parse_moment(const std::string& text, const record::RunInfo& info,
                                            const std::string& option);

/// Fails with usage where `every` is shorter than the record's rows are apart, or no whole number of its seconds.
[[nodiscard]] Result<void> check_choice(const ExportChoice& choice, const record::RunInfo& info);

/// The rows that are chosen. Where they are put together, stretches are counted from the start of the run, and a row
/// has the time of the first that is in it: temperatures, rates and values are the means of what is there, pulses and
/// their intervals are added (an axis of which a second is missing has no sum), and where the profile stood is that of
/// the first row. Events and gaps stay as they are. Where every row is chosen it is the record itself.
[[nodiscard]] record::Record chosen_rows(record::Record record, const ExportChoice& choice);

}  // namespace gyrotherm::exchange
