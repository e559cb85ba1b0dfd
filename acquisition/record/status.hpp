// SPDX-License-Identifier: Apache-2.0
/// The status of a run from its record and from the status file beside it (status_file.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status_file.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// Of the status file if a program is writing the record, else of the record itself. Fails with bad_file (no record) or
/// storage (damaged, or being written with no status file to tell more).
[[nodiscard]] Result<RunStatus> read_status(const RecordFiles& files);
[[nodiscard]] Result<RunStatus> read_status(const std::string& path);

/// What a record has lost of its end.
struct LostEnd {
  std::int64_t last{};          ///< second that it holds; −1: none
  std::int64_t acknowledged{};  ///< … that its status file says was on the disk
};
/// "ends at second 90, but second 100 was acknowledged: its end is lost".
[[nodiscard]] std::string describe(const LostEnd& lost);
/// Compares the record of a run that was not finished, and that nobody writes, with the status file of the same run
/// beside it. Nothing if it holds all that was acknowledged, or if there is no such file to say. Fails like
/// read_record().
[[nodiscard]] Result<std::optional<LostEnd>> lost_end(const RecordFiles& files);

/// Reads the alarms from all files of the record. Fails like read_record().
[[nodiscard]] Result<Alarms> alarms_of(const RecordFiles& files);

/// The highest number that an event has in any file of the record; 0: there is none. Fails like read_record().
[[nodiscard]] Result<std::int64_t> last_event_of(const RecordFiles& files);

// Where a run stands, as its record tells it.

/// Of a run before its first sample.
[[nodiscard]] RunStatus first_status(const std::string& path, const RunInfo& info);

/// Puts a sample's place in the profile into the status.
void show_progress(RunStatus& status, const RunInfo& info, const ProfilePosition& progress);

/// Of one open file of a record: its last sample and its counts; the slots before those that it goes on with count as
/// acknowledged.
[[nodiscard]] Result<RunStatus> stored_status(Database& database, const std::string& path);

}  // namespace gyrotherm::record
