// SPDX-License-Identifier: Apache-2.0
/// The status of a run and its file next to the record. The writer of the record replaces the file after each sync.
/// Readers therefore need not open a record that is being written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/decision.hpp"
#include "acquisition/record/rate_meter.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

inline constexpr const char* kStatusSchema = "gyrotherm-status/1";

/// The status of a run.
struct RunStatus {
  std::string path;  ///< path of the record
  std::string id;
  /// The process of the last known writer; 0 if it is unknown.
  std::int64_t pid{};
  /// A program has the record open for writing.
  bool being_written{};
  bool finished{};
  /// The results of the run are marked as SIMULATED.
  bool simulated{};
  /// The virtual instruments of a real rig (RunInfo::virtual_instruments).
  std::vector<std::string> virtual_instruments{};
  /// Titles of the run's texts without a valid release (RunInfo::releases).
  std::vector<std::string> unreleased{};
  /// The slot of the last sample and the last slot on the disk; −1 if there is none yet.
  std::int64_t slot{-1};
  std::int64_t acknowledged{-1};
  std::string segment;
  int segment_index{};
  int segment_count{};
  Phase phase{};
  std::optional<Celsius> set_point;  ///< the profile's set point
  std::optional<Celsius> chamber_air;
  /// The set point that the chamber shows; nothing if it is unknown.
  std::optional<Celsius> chamber_set_point{};
  /// The channels and their readings; a reading is nothing if it is a fault.
  std::vector<std::pair<std::string, std::optional<Celsius>>> thermometers;
  /// The number of failed readings since the run started.
  std::int64_t faults{};
  /// The part of `faults` that are readings of units in segments that switch the units off.
  std::int64_t faults_while_off{};
  /// The frames of all gyros since the run started; nothing before the first second.
  std::optional<FrameCount> frames{};

  /// The state of the run. Its times and faults are known only while a program writes the record.
  RunOverview overview{};
  /// The cause of the end of the run, if an event of a record that is not being written states it.
  std::string ended_by{};
  /// The number of seconds of data that wait for the disk.
  std::int64_t backlog_s{};
  /// The reason why the disk accepts no rows; empty if it does.
  std::string storage_trouble{};
  /// The damage that another program did to the record's files; empty if there is none.
  std::string record_damage{};
  /// Time of the sample `slot` since the machine was booted, and that boot. A file of an earlier version does not state
  /// them; they are then those of the file.
  Duration slot_since_boot{};
  std::string slot_in_boot{};
  /// Time when the status file was written: UTC of the wall clock, and time since the machine was booted.
  Duration written_utc{};
  Duration written_since_boot{};
  /// The boot identifier of the machine at that time; empty if the status does not come from a file.
  std::string written_in_boot{};
  /// The paths of the further files of the record, each begun after a failure.
  std::vector<std::string> parts{};
  /// The reason why the live copy is not up to date; empty if it is, or if there is none.
  std::string live_copy_trouble{};
  /// The alarms that are active, unacknowledged or shelved, the newest first (Alarms::list()).
  std::vector<Alarm> alarms{};
  /// The present rates of the gyros; empty unless the record is being written.
  std::vector<AxisRate> gyro_rates{};
  /// The last decision of a run that ends by itself; nothing before the first one.
  std::optional<Decision> decision{};
};

/// Returns whether the run is in virtual time: all of its instruments are virtual.
[[nodiscard]] bool is_in_virtual_time(const RunStatus& status);

/// Describes a state and its cause: "execute", "held: the profile asks: …". Returns only the cause if it already names
/// the state, as in "stopped by ada".
[[nodiscard]] std::string describe(RunState state, const std::string& cause);

/// Returns the path of the status file: "RUN.db.status" for "RUN.db".
[[nodiscard]] std::string status_path(const std::string& record_path);

/// Writes a status as one line of JSON. The keys are the members of RunStatus with units (`set_point_c`); unknown
/// values are null.
[[nodiscard]] std::string to_json(const RunStatus& status);
/// Parses the output of to_json(). Fails with bad_file on any other text; `where` is the location in the fault.
[[nodiscard]] Result<RunStatus> parse_status(const std::string& text, const std::string& where);

/// Replaces the status file of the record status.path atomically, and adds the present time to it. Only its owner and
/// group may read the file (0640). Fails with storage.
[[nodiscard]] Result<void> write_status(const RunStatus& status);

/// Returns the age of a status file. Returns nothing if the machine was restarted since the file was written, or if the
/// status does not come from a file.
[[nodiscard]] std::optional<Duration> status_age(const RunStatus& status);
/// A status file older than this means that its writer, or the writer's disk, does not respond.
inline constexpr Duration kSilentAfter = std::chrono::seconds(5);

/// Reads the status file of a record. Fails as read_text_file() and parse_status() do.
[[nodiscard]] Result<RunStatus> read_status_file(const std::string& record_path);

/// Reads the status file of a record without checking its writer and age. Returns nothing if there is no readable
/// status file.
[[nodiscard]] std::optional<RunStatus> read_status_file_if_any(const std::string& path);
/// Returns whether the program that executes the run wrote the status less than kSilentAfter ago.
[[nodiscard]] bool is_fresh(const RunStatus& status);

/// Returns the status file of a record if it is_fresh(), and nothing otherwise. A caller with a fresh status need not
/// test the lock of the record.
[[nodiscard]] std::optional<RunStatus> read_fresh_status(const std::string& path);

}  // namespace gyrotherm::record
