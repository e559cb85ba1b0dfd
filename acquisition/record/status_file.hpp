// SPDX-License-Identifier: Apache-2.0
/// Where a run stands: written beside the record after each sync, so that nobody needs to open a record being written.
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
  std::string path;  ///< of the record
  std::string id;
  std::int64_t pid{};    ///< of the last known writer; 0: unknown
  bool being_written{};  ///< a program holds the record now
  bool finished{};
  bool simulated{};
  std::int64_t slot{-1};          ///< of the last sample; −1: none yet
  std::int64_t acknowledged{-1};  ///< the last slot that is on the disk
  std::string segment;
  int segment_index{};
  int segment_count{};
  Phase phase{};
  std::optional<Celsius> set_point;
  std::optional<Celsius> chamber_air;
  std::vector<std::pair<std::string, std::optional<Celsius>>> thermometers;  ///< channel and reading; nothing: a fault
  std::int64_t faults{};               ///< readings that were faults, since the run started
  std::optional<FrameCount> frames{};  ///< of all gyros, since the run started; nothing before the first second

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

/// "held: the profile asks: …", "execute", and "stopped by ada" where the cause says the state.
[[nodiscard]] std::string in_words(RunState state, const std::string& cause);

/// "RUN.db" → "RUN.db.status".
[[nodiscard]] std::string status_path(const std::string& record_path);

/// One line, keys as in RunStatus with units (`set_point_c`), null where nothing is known.
[[nodiscard]] std::string to_json(const RunStatus& status);
/// Fails with bad_file if the text is not what to_json() writes; `where` names its place.
[[nodiscard]] Result<RunStatus> parse_status(const std::string& text, const std::string& where);

/// Replaces the status file of status.path as a whole, with the time: a reader sees the old one or the new one; for
/// owner and group (0640). Fails with storage.
[[nodiscard]] Result<void> write_status(const RunStatus& status);

/// How long ago a status file was written; nothing if that cannot be told: the machine was started anew since, or it is
/// none.
[[nodiscard]] std::optional<Duration> age_of(const RunStatus& status);
/// … after which the program that writes it, or its disk, no longer answers.
inline constexpr Duration kSilentAfter = std::chrono::seconds(5);

/// Reads the status file of a record. Fails as read_text_file() and parse_status() do.
[[nodiscard]] Result<RunStatus> read_status_file(const std::string& record_path);

/// What the status file of a record says, whoever wrote it and when; nothing if there is none.
[[nodiscard]] std::optional<RunStatus> told_status(const std::string& path);
/// Whether a program that carries the run out has written it less than kSilentAfter ago.
[[nodiscard]] bool is_fresh(const RunStatus& status);

/// The status that the program which carries the run out has written less than kSilentAfter ago, so that nobody needs
/// to try whether the record is free; nothing if there is none.
[[nodiscard]] std::optional<RunStatus> fresh_status(const std::string& path);

}  // namespace gyrotherm::record
