// SPDX-License-Identifier: Apache-2.0
/// Where the rows of a run are read from: its live copy while a program writes the record, else the closed record's own
/// files. A record that is being written is never opened, and nothing beside a record is made, changed or removed.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

inline constexpr std::int64_t kNoEnd = std::numeric_limits<std::int64_t>::max();

/// Opens one file to read it. What is in it is looked at once (check_schema) and not again until the file changes.
/// Fails with storage if it is a record being written, with bad_file if it is none. Any thread.
[[nodiscard]] Result<Database> open_source(const Part& part);

/// The files that a run is read from now: of one that is `running` the live copy, of another the record, which has more
/// than the copy that a dead program left. Where the one is not there it is the other; of a copy no run_id is known.
/// Fails with storage while a record is being written that has no live copy, with bad_file if there is no record.
[[nodiscard]] Result<RecordFiles> find_source_files(const std::string& record_path, bool running);

/// Whether the run has a sample: before its first one a real run does not know when it started.
[[nodiscard]] Result<bool> has_begun(const RecordFiles& files);

/// What the run knew before its first sample, and when it started.
[[nodiscard]] Result<RunInfo> read_source_info(const RecordFiles& files);

/// Calls `use` with the rows of `SELECT what FROM table WHERE slot BETWEEN first AND last ORDER BY order`, over all
/// files in turn, at most `most` of them; of each file from the slot before its own first on, to which the events
/// belong that came before its first row; `key` names the column that has the slot. It stops where `use` returns false.
struct RowQuery {
  std::string what;
  std::string table = "sample";
  std::string key = "slot";
  std::string order = "slot";
  std::int64_t first{}, last{kNoEnd};
  std::int64_t most{kNoEnd};
};
[[nodiscard]] Result<void> each_row(const RecordFiles& files, const RowQuery& query,
                                    const std::function<bool(const Statement&)>& use);

}  // namespace gyrotherm::record
