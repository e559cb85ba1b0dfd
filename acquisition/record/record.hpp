// SPDX-License-Identifier: Apache-2.0
/// A record, read back.
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

/// What a unit under test measured, as columns.
struct UnitColumns {
  std::vector<std::vector<double>> rotation;  ///< per axis: pulses, or the foreign number
  std::vector<double> interval_s;             ///< over which the pulses were counted
  std::vector<std::vector<double>> values;    ///< per value of the unit
  std::vector<std::vector<double>>
      true_bias_deg_per_h;  ///< per axis, of a virtual gyro: what temperatures and warm-up made of its bias
};

/// Columns of equal length, one row per sample in order of time; NaN where a reading was a fault.
struct Record {
  RunInfo info;
  bool finished{};
  std::vector<std::int64_t> slot;   ///< imported: the row number
  std::vector<double> time_s;       ///< since the run started (imported: since the first row)
  std::vector<double> set_point_c;  ///< what the profile asked for
  std::vector<double> chamber_air_c;
  std::vector<double> chamber_set_point_c;          ///< as read back
  std::vector<std::vector<double>> thermometers_c;  ///< per channel of info.thermometers, raw
  std::vector<UnitColumns> units;                   ///< per unit of info.units
  std::vector<ProfilePosition> progress;
  std::vector<RunState> state;         ///< execute throughout an imported record
  std::optional<Duration> last_utc{};  ///< the wall clock at the last row; imported: none
  std::vector<Gap> gaps;
  std::vector<RecordedEvent> events;
};

/// The segment of a row, or null where none is known, as in an imported record.
[[nodiscard]] const RunInfo::SegmentInfo* segment_at(const Record& record, std::size_t row);

/// Whether the profile puts the unit into people's hands: to turn it around, or for whatever else a prompt asks.
[[nodiscard]] bool is_handled(const RunInfo& info);
/// How the unit was mounted in a row: 1 where it was turned around, 0 where not; NaN while it was in people's hands, as
/// it is until the clock of a segment with a prompt runs.
[[nodiscard]] double turned_at(const Record& record, std::size_t row);

/// Reads everything, of all the files that the record consists of (a file that failed is followed by RUN.2.db, …). One
/// that others go on from, and that is gone or not as it was written, is passed over: slots that are in none of them
/// are a gap, "lost with RUN.db: …". With the name of a unit only what was measured of the rig and of that unit is read
/// (serves() says which thermometers that are); the columns of the others are empty. Safe while a run is being written?
/// No: it refuses with storage ("being written by …"); see status.hpp. Fails with bad_file (not a record, another
/// schema version, damaged).
[[nodiscard]] Result<Record> read_record(const RecordFiles& files, const std::string& unit = {});
[[nodiscard]] Result<Record> read_record(const std::string& path, const std::string& unit = {});
/// Reads everything as read_record() does, but only if the chain fits in every file that is read. Fails with bad_file
/// naming the first row that does not fit, and as read_record() does.
[[nodiscard]] Result<Record> read_proved_record(const RecordFiles& files);
/// What a record knew before its first sample, by the first of its files that can be read. Fails likewise.
[[nodiscard]] Result<RunInfo> read_info(const RecordFiles& files);
[[nodiscard]] Result<RunInfo> read_info(const std::string& path);

/// Finds the files of a record as find_record_files() does, and fails as read_record() does.
[[nodiscard]] Result<RecordFiles> find_files_to_read(const std::string& path);
/// Returns the fault with which read_record() fails: as bad_file that the record is damaged or, if a program writes it,
/// also which process that is.
[[nodiscard]] Fault explain_read_fault(Fault fault, const std::string& path);
/// Reads one open file; of its samples only the wanted ones. Fails with storage.
[[nodiscard]] Result<Record> record_of(Database& database, const Wanted& wanted = {});

}  // namespace gyrotherm::record
