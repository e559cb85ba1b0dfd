/// Where a run stands: written beside the record after each sync, so that nobody needs to open a record being written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm {

inline constexpr const char* kStatusSchema = "gyrotherm-status/1";

struct RunStatus {
  struct Thermometer {
    std::string channel;
    std::optional<Celsius> reading;  ///< nothing: a fault
  };
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
  std::vector<Thermometer> thermometers;
  std::int64_t faults{};               ///< readings that were faults, since the run started
  std::optional<FrameCount> frames{};  ///< the gyro's, since the run started; nothing: an older record
};

/// "RUN.db" → "RUN.db.status".
[[nodiscard]] std::string status_path(const std::string& record_path);

/// One line, keys as in RunStatus with units (`set_point_c`), null where nothing is known.
[[nodiscard]] std::string to_json(const RunStatus& status);
/// Fails with bad_file if the text is not what to_json() writes; `where` names its place.
[[nodiscard]] Result<RunStatus> parse_status(const std::string& text, const std::string& where);

/// Replaces the status file of status.path as a whole: a reader sees the old one or the new one. Fails with storage.
[[nodiscard]] Result<void> write_status(const RunStatus& status);

/// Of the status file if a program is writing the record, else of the record itself. Fails with bad_file (no record) or
/// storage (damaged, or being written with no status file to tell more).
[[nodiscard]] Result<RunStatus> read_status(const std::string& path);

}  // namespace gyrotherm
