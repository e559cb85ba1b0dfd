// SPDX-License-Identifier: Apache-2.0
/// Reads the status of a run from its record and from the status file next to it (status_file.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status_file.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// Returns the status in the status file if a program is writing the record, and otherwise the status of the record.
/// Fails with bad_file if there is no record, and with storage if the record is damaged or is being written without a
/// status file.
[[nodiscard]] Result<RunStatus> read_status(const RecordFiles& files);
[[nodiscard]] Result<RunStatus> read_status(const std::string& path);

/// The end of a record that was acknowledged but is missing.
struct LostEnd {
  /// The last second in the record; −1 if there is none.
  std::int64_t last{};
  /// The last second that the status file reports as stored.
  std::int64_t acknowledged{};
};
/// Describes the loss: "ends at second 90, but second 100 was acknowledged: its end is lost".
[[nodiscard]] std::string describe(const LostEnd& lost);
/// Compares the record of an unfinished run with the status file of the same run. No program may be writing the record.
/// Returns nothing if the record has all acknowledged seconds or has no status file. Fails as read_record() does.
[[nodiscard]] Result<std::optional<LostEnd>> lost_end(const RecordFiles& files);

/// Returns the names of the files that an unfinished record needs and that are missing beside it: the log of its last
/// file, and the status file if that is missing too. Returns nothing if the last file is complete, as these show: the
/// status file of the same run acknowledges no later second; the last writer closed the record in order; the run is
/// finished; the file is a live copy. Fails as read_record() does, also if a program is writing the record.
[[nodiscard]] Result<std::vector<std::string>> missing_files(const RecordFiles& files);
/// Describes them: "k.db-wal and k.db.status are missing; move all files of a record together".
[[nodiscard]] std::string describe_missing(const std::vector<std::string>& names);

/// Reads the alarms from all files of the record. Fails as read_record() does.
[[nodiscard]] Result<Alarms> read_record_alarms(const RecordFiles& files);

/// Returns the highest event number in all files of the record; 0 if there is none. Fails as read_record() does.
[[nodiscard]] Result<std::int64_t> read_last_event_number(const RecordFiles& files);

// The status of a run computed from its record.

/// Returns the status of a run before its first sample.
[[nodiscard]] RunStatus make_first_status(const std::string& path, const RunInfo& info);

/// Sets the segment, the phase and the set point of the status from a sample's profile position.
void set_progress(RunStatus& status, const RunInfo& info, const ProfilePosition& progress);

/// Returns the status of one open file of a record: its last sample and its counts. Treats the slots of earlier parts
/// as acknowledged.
[[nodiscard]] Result<RunStatus> read_stored_status(Database& database, const std::string& path);

}  // namespace gyrotherm::record
