// SPDX-License-Identifier: Apache-2.0
/// The history of check runs that the rig file in a record names (docs/check-standard.md).
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"

namespace gyrotherm::record {

/// Name of the history if the rig file does not name one.
inline constexpr const char* kDefaultCheckHistory = "check-standard.jsonl";

/// Returns the paths at which the history of check runs of the run's rig may be, in the order of a search: beside the
/// rig file that the record names, then beside `record`. Empty if the rig file in the record has no [check_standard].
[[nodiscard]] std::vector<std::string> list_check_histories(const RunInfo& info, const std::string& record);

/// The history of check runs that the rig file in a record names.
struct NamedHistory {
  /// Paths at which the history may be (list_check_histories()).
  std::vector<std::string> paths{};
  /// Name of the rig in the rig file.
  std::string rig{};
  bool simulated{};
  auto operator<=>(const NamedHistory&) const = default;

  /// Returns the first path that exists; empty if there is none.
  [[nodiscard]] std::string find_path() const;
  /// Returns whether a history for `history_rig` belongs to this rig. A record from elsewhere may name any file.
  [[nodiscard]] bool is_for(std::string_view history_rig, bool is_history_simulated) const {
    return history_rig == rig && is_history_simulated == simulated;
  }
};
/// Returns the history that a record names; nothing if the rig has no check standard.
[[nodiscard]] std::optional<NamedHistory> find_named_history(const RunInfo& info, const std::string& record);

}  // namespace gyrotherm::record
