/// RunInfo as rows of a record, there and back.
#pragma once

#include <string>
#include <string_view>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Inside the caller's transaction, into fresh tables.
[[nodiscard]] Result<void> write_run_info(Database& database, const RunInfo& info);

/// What write_run_info() wrote, to the bit. Fails with bad_file if a name in it could not have been written.
[[nodiscard]] Result<RunInfo> read_run_info(Database& database);

/// The value of a key of the table `meta`, as text; empty if it is not there.
[[nodiscard]] Result<std::string> meta(Database& database, std::string_view key);

[[nodiscard]] Result<void> mark_finished(Database& database);
[[nodiscard]] Result<bool> is_finished(Database& database);

}  // namespace gyrotherm
