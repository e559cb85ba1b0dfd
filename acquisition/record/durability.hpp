/// What makes SQLite keep its word: how a record's file is made, claimed and written so that a commit that has returned
/// is on the disk.
#pragma once

#include <string>

#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// How long a writer waits for another program's lock: a second program is told within a second.
inline constexpr int kWriterPatienceMs = 500;

/// An empty file that did not exist before, mode 0640; SQLite takes it for an empty database. Fails with storage.
[[nodiscard]] Result<void> make_new_file(const std::string& path);

/// Nobody else reads or writes the database until it is closed. Comes before make_durable(), so that the log's index
/// lives in memory and there is no file of it. All that follow fail with storage.
[[nodiscard]] Result<void> claim(Database& database, const std::string& path);
/// The way out of WAL mode leaves no journal behind for a reader to play back.
[[nodiscard]] Result<void> keep_no_journal(Database& database, const std::string& path);
/// A commit is on the disk when it returns; the log is folded in when the writer says so.
[[nodiscard]] Result<void> make_durable(Database& database, const std::string& path);

}  // namespace gyrotherm
