// SPDX-License-Identifier: Apache-2.0
/// The history of check runs that the rig file in a record names (docs/check-standard.md).
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"

namespace gyrotherm::record {

/// Name of the history if the rig file does not name one.
inline constexpr const char* kDefaultCheckHistory = "check-standard.jsonl";

/// Returns the paths at which the history of check runs of the run's rig may be, in the order of a search: beside the
/// rig file that the record names, then beside `record`. Empty if the rig file in the record has no [check_standard].
[[nodiscard]] std::vector<std::string> list_check_histories(const RunInfo& info, const std::string& record);

}  // namespace gyrotherm::record
