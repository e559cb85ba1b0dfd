// SPDX-License-Identifier: Apache-2.0
/// Reads a record into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/record_files.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

struct Gap {
  std::int64_t first{};
  std::int64_t last{};
  std::string cause;
};

/// The measurements of a unit under test, as columns.
struct UnitColumns {
  /// The pulses of each axis, or the number that an imported record stores for it.
  std::vector<std::vector<double>> rotation;
  /// The time in which the pulses were counted.
  std::vector<double> interval_s;
  /// Readings of the unit's other values: one vector per value, one entry per row.
  std::vector<std::vector<double>> values;
  /// Bias of each axis that temperatures and warm-up cause in a virtual gyro.
  std::vector<std::vector<double>> true_bias_deg_per_h;
};

/// A record as columns of equal length, with one row per sample in order of time. NaN means that the reading was a
/// fault.
struct Record {
  RunInfo info;
  bool finished{};
  std::vector<std::int64_t> slot;  ///< row number if imported
  /// Time since the start of the run; imported: since the first row.
  std::vector<double> time_s;
  std::vector<double> set_point_c;  ///< demanded by the profile
  std::vector<double> chamber_air_c;
  std::vector<double> chamber_set_point_c;  ///< read back from the chamber
  /// Empty unless info.has_humidity or info.has_dew_point.
  std::vector<double> chamber_humidity_percent;
  std::vector<double> chamber_dew_point_c;
  /// Raw readings, one column per element of info.thermometers.
  std::vector<std::vector<double>> thermometers_c;
  /// One element per element of info.units.
  std::vector<UnitColumns> units;
  std::vector<ProfilePosition> progress;
  /// The state of the run; always execute in an imported record.
  std::vector<RunState> state;
  /// The wall clock at the last row; nothing if imported.
  std::optional<Duration> last_utc{};
  std::vector<Gap> gaps;
  std::vector<RecordedEvent> events;
};

/// Appends a second to a record in memory, as read_record() would read it from the file. If seconds are missing before
/// it, they become a gap without a cause.
void append_sample(Record& record, const Sample& sample);

/// Returns the segment of a row, or null if it is unknown, as in an imported record.
[[nodiscard]] const RunInfo::SegmentInfo* segment_at(const Record& record, std::size_t row);

/// Returns for each row whether the chamber was away from the profile: the run was aborted or stopped, or a resumed run
/// was on its way back.
[[nodiscard]] std::vector<bool> find_rows_away(const Record& record);

/// Returns whether operators handle the unit during the profile: a prompt requests any action on the unit.
[[nodiscard]] bool has_operator_actions(const RunInfo& info);
/// Returns the mounting of the unit in a row: 1 if it was turned around, 0 if not. Returns NaN while an operator
/// handles the unit: in a segment with a prompt, until the clock of the segment starts.
[[nodiscard]] double turned_at(const Record& record, std::size_t row);

/// Reads all rows of all files of the record (a file that failed is followed by RUN.2.db, …). Skips a file that is
/// missing or was changed if a later file continues it. Slots that are in no file become a gap, "lost with RUN.db: …".
/// If `unit` is not empty, reads only the measurements of the rig and of that unit (serves() selects the thermometers),
/// and leaves the columns of other units empty. Fails with storage ("being written by …") while a program writes the
/// record; status.hpp covers that case. Fails with bad_file if the file is not a record, has another schema version, or
/// is damaged.
[[nodiscard]] Result<Record> read_record(const RecordFiles& files, const std::string& unit = {});
[[nodiscard]] Result<Record> read_record(const std::string& path, const std::string& unit = {});
/// Reads the record as read_record() does, and verifies the chain of every file. Fails with bad_file, naming the
/// first row that does not match, or as read_record() does.
[[nodiscard]] Result<Record> read_verified_record(const RecordFiles& files);
/// Reads the description of the run from the first readable file, and the segments that decisions have added from the
/// last one. Fails as read_record() does.
[[nodiscard]] Result<RunInfo> read_info(const RecordFiles& files);
[[nodiscard]] Result<RunInfo> read_info(const std::string& path);

/// Finds the files of a record as find_record_files() does, and fails as read_record() does.
[[nodiscard]] Result<RecordFiles> find_files_to_read(const std::string& path);
/// Converts a storage fault to the one that read_record() reports: bad_file for a damaged record. If a program is
/// writing the record, adds its process to the fault.
[[nodiscard]] Fault explain_read_fault(Fault fault, const std::string& path);
/// Reads one open file, restricted to the `wanted` samples. Fails with bad_file if the content is not that of a record,
/// otherwise with storage.
[[nodiscard]] Result<Record> read_open_record(Database& database, const ReadSelection& wanted = {});

}  // namespace gyrotherm::record
