// SPDX-License-Identifier: Apache-2.0
/// Reads the rows of a run from its live copy while a program writes the record, and otherwise from the files of the
/// closed record. Never opens a record that is being written, and does not create, change or remove any file.
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

/// Opens one file for reading. Checks its schema (check_schema()) at the first opening, and again if the file has
/// changed since or, for a live copy, was replaced. Fails with storage if the file is a record that is being written,
/// and with bad_file if it is not a record. Any thread may call it.
[[nodiscard]] Result<Database> open_source(const Part& part);

/// Finds the files from which to read a run. Prefers the live copy if the run is `running`. Otherwise prefers the
/// record, because a copy that a dead program left has fewer rows. If the preferred source cannot be used, returns the
/// other. The run_id of a copy is empty. Fails with storage while a record without a live copy is being written, and
/// with bad_file if there is no record.
[[nodiscard]] Result<RecordFiles> find_source_files(const std::string& record_path, bool running);

/// Returns true if the run has a sample. The start time of a real run is unknown before its first sample.
[[nodiscard]] Result<bool> has_begun(const RecordFiles& files);

/// Reads the description and the start time of the run.
[[nodiscard]] Result<RunInfo> read_source_info(const RecordFiles& files);

/// Selects rows: `SELECT what FROM table WHERE key BETWEEN first AND last ORDER BY order LIMIT most`.
struct RowQuery {
  std::string what;
  std::string table = "sample";
  std::string key = "slot";  ///< the column with the slot
  std::string order = "slot";
  std::int64_t first{}, last{kNoEnd};
  std::int64_t most{kNoEnd};
};

/// Calls `use` with the selected rows of all files in turn, until `use` returns false. Starts each file one
/// slot before its first row, because events that precede the first row belong to that slot.
[[nodiscard]] Result<void> each_row(const RecordFiles& files, const RowQuery& query,
                                    const std::function<bool(const Statement&)>& use);

}  // namespace gyrotherm::record
