// SPDX-License-Identifier: Apache-2.0
/// State of the check standard at the time of a record: the check runs before and after it, and their verdicts.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "analysis/assurance/history.hpp"

namespace gyrotherm::assurance {

enum class CheckState {
  unknown,         ///< no check run beside the record has been judged
  in_control,      ///< the check runs beside the record are in control
  explained,       ///< one of them was out of control and has an explanation
  out_of_control,  ///< made after the last run in control before the first one that is not explained
};
/// Returns "unknown", "in_control", "explained" or "out_of_control".
[[nodiscard]] const char* name(CheckState state);

struct RecordState {
  CheckState state{};
  std::optional<std::size_t> before{};  ///< index of the last check run that started before the record, or with it
  std::optional<std::size_t> after{};   ///< index of the first check run that started later
};

/// Returns the state at the start of a record, "2026-11-25T14:03:07Z". A record that was made before any check run is
/// out of control only if no run was in control before the first open one.
[[nodiscard]] RecordState find_state(const History& history, const Assessment& assessment,
                                     const std::string& started_utc);

}  // namespace gyrotherm::assurance
