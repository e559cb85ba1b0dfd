/// RunInfo as rows of a record, there and back.
#pragma once

#include "acquisition/run_info.hpp"
#include "acquisition/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Inside the caller's transaction, into fresh tables.
[[nodiscard]] Result<void> write_run_info(Database& database, const RunInfo& info);

/// What write_run_info() wrote, to the bit. Fails with bad_file if a name in it could not have been written.
[[nodiscard]] Result<RunInfo> read_run_info(Database& database);

[[nodiscard]] Result<void> mark_finished(Database& database);
[[nodiscard]] Result<bool> is_finished(Database& database);

}  // namespace gyrotherm
