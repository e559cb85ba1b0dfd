// SPDX-License-Identifier: Apache-2.0
/// Finds the runs that lie in a folder, without opening any record.
#pragma once

#include <set>
#include <string>

namespace gyrotherm::record {

/// The paths of the records that lie in a folder, also of those that nothing but a status file tells of: "soak.db" is
/// one; "soak.live.db" and "soak.2.db", which belong to it, are not, unless there is no such record, or the latter has
/// a status file of its own, as no part has.
[[nodiscard]] std::set<std::string> records_in(const std::string& folder);

}  // namespace gyrotherm::record
