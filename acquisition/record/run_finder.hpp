// SPDX-License-Identifier: Apache-2.0
/// Finds the runs that lie in a folder, and tells whether a program carries one out, without opening any record.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "acquisition/record/status.hpp"

namespace gyrotherm::record {

/// The paths of the records that lie in a folder, also of those that nothing but a status file tells of: "soak.db" is
/// one; "soak.live.db" and "soak.2.db", which belong to it, are not, unless there is no such record, or the latter has
/// a status file of its own, as no part has.
[[nodiscard]] std::set<std::string> records_in(const std::string& folder);

/// What the status file of a record says, whoever wrote it and when; nothing if there is none.
[[nodiscard]] std::optional<RunStatus> told_status(const std::string& path);
/// Whether a program that carries the run out has written it less than kSilentAfter ago.
[[nodiscard]] bool is_fresh(const RunStatus& status);

/// The status that the program which carries the run out has written less than kSilentAfter ago, so that nobody needs
/// to try whether the record is free; nothing if there is none.
[[nodiscard]] std::optional<RunStatus> fresh_status(const std::string& path);

}  // namespace gyrotherm::record
