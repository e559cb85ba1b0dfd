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

/// Opens one file for reading. Checks its content (check_schema) at the first time and again after the file has
/// changed. Fails with storage if it is a record being written, with bad_file if it is not a record. Any thread.
[[nodiscard]] Result<Database> open_source(const Part& part);

/// Finds the files to read a run from. The live copy is preferred if the run is `running`, and otherwise the record,
/// because it has more rows than the copy that a dead program left. Returns the other source if the preferred one is
/// missing. The run_id of a copy is empty. Fails with storage while a record without a live copy is being written, and
/// with bad_file if there is no record.
[[nodiscard]] Result<RecordFiles> find_source_files(const std::string& record_path, bool running);

/// Returns true if the run has a sample. Before its first sample a real run does not know when it started.
[[nodiscard]] Result<bool> has_begun(const RecordFiles& files);

/// Reads the description of the run that exists before its first sample, and the time of its start.
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

/// Calls `use` with the selected rows of all files in turn, until `use` returns false. Reads each file from the slot
/// before its own first one, to which events before its first row belong.
[[nodiscard]] Result<void> each_row(const RecordFiles& files, const RowQuery& query,
                                    const std::function<bool(const Statement&)>& use);

}  // namespace gyrotherm::record
