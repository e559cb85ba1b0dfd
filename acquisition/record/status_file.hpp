// SPDX-License-Identifier: Apache-2.0
/// The status of a run, and its file beside the record. The writer of the record replaces the file after each sync, so
/// readers need not open a record that is being written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/rate_meter.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

inline constexpr const char* kStatusSchema = "gyrotherm-status/1";

struct RunStatus {
  std::string path;  ///< the record
  std::string id;
  std::int64_t pid{};    ///< the last known writer; 0: unknown
  bool being_written{};  ///< a program has the record open for writing
  bool finished{};
  bool simulated{};
  std::int64_t slot{-1};          ///< slot of the last sample; −1: no sample yet
  std::int64_t acknowledged{-1};  ///< last slot on the disk
  std::string segment;
  int segment_index{};
  int segment_count{};
  Phase phase{};
  std::optional<Celsius> set_point;
  std::optional<Celsius> chamber_air;
  std::vector<std::pair<std::string, std::optional<Celsius>>> thermometers;  ///< channel and reading; nothing: a fault
  std::int64_t faults{};                                                     ///< faulty readings since the run started
  std::optional<FrameCount> frames{};  ///< frames of all gyros since the run started; nothing before the first second

  RunStanding standing{};              ///< times and faults are known while a program writes the record
  std::string ended_by{};              ///< the record's last word, where no program writes it: why the run stopped
  std::int64_t backlog_s{};            ///< seconds that wait for the disk
  std::string storage_trouble{};       ///< why the disk takes no rows; empty: it does
  std::string record_damage{};         ///< what another program did to the record's files; empty: nothing
  Duration written_utc{};              ///< when the status file was written
  Duration written_since_boot{};       ///< … since the start of the machine that written_in_boot names
  std::string written_in_boot{};       ///< empty: this does not come from a status file
  std::vector<std::string> parts{};    ///< files that the record goes on in after a failure of its own
  std::string live_copy_trouble{};     ///< why the live copy does not follow; empty: it does, or there is none
  std::vector<Alarm> alarms{};         ///< active or unacknowledged, newest first (Alarms::list())
  std::vector<AxisRate> gyro_rates{};  ///< empty unless being written
};

/// Describes a state and its cause: "execute", "held: the profile asks: …", or the cause alone if it names the state,
/// as "stopped by ada".
[[nodiscard]] std::string in_words(RunState state, const std::string& cause);

/// Returns the path of the status file: "RUN.db.status" for "RUN.db".
[[nodiscard]] std::string status_path(const std::string& record_path);

/// Writes a status as one line of JSON. Keys are those of RunStatus with units (`set_point_c`); unknown values are
/// null.
[[nodiscard]] std::string to_json(const RunStatus& status);
/// Fails with bad_file if the text is not what to_json() writes; `where` names its place.
[[nodiscard]] Result<RunStatus> parse_status(const std::string& text, const std::string& where);

/// Replaces the status file of status.path atomically and adds the time. Only owner and group may read it (0640). Fails
/// with storage.
[[nodiscard]] Result<void> write_status(const RunStatus& status);

/// Returns the age of a status file. Returns nothing if the machine was restarted since, or if the status does not come
/// from a file.
[[nodiscard]] std::optional<Duration> age_of(const RunStatus& status);
/// The age from which the writer, or its disk, counts as silent.
inline constexpr Duration kSilentAfter = std::chrono::seconds(5);

/// Reads the status file of a record. Fails as read_text_file() and parse_status() do.
[[nodiscard]] Result<RunStatus> read_status_file(const std::string& record_path);

/// Reads the status file of a record, whatever its writer and age. Returns nothing without a readable one.
[[nodiscard]] std::optional<RunStatus> told_status(const std::string& path);
/// Returns whether the program that carries out the run wrote it less than kSilentAfter ago.
[[nodiscard]] bool is_fresh(const RunStatus& status);

/// Returns the status file of a record if it is_fresh(), and nothing otherwise. With it a caller need not try whether
/// the record is free.
[[nodiscard]] std::optional<RunStatus> fresh_status(const std::string& path);

}  // namespace gyrotherm::record
