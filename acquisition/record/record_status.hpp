/// Where a run stands, as its record tells it.
#pragma once

#include <string>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Of a run before its first sample.
[[nodiscard]] RunStatus first_status(const std::string& path, const RunInfo& info);

/// Puts a sample's place in the profile into the status.
void show_progress(RunStatus& status, const RunInfo& info, const ProfilePosition& progress);

void show_outlook(RunStatus& status, const Outlook& outlook);

/// Of an open record: its last sample and its counts.
[[nodiscard]] Result<RunStatus> stored_status(Database& database, const std::string& path);

}  // namespace gyrotherm
