// SPDX-License-Identifier: Apache-2.0
/// Names, finds and opens the files of a record. Any thread may call these functions.
///
/// When the file of a record fails, the run continues in a second file next to it, then in a third. Each of these parts
/// stores the name of the file before it. While a program writes the record, there is also a live copy next to it
/// (live_copy.hpp). find_record_files() searches for the files once, and every reader of the record uses its result.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm::record {

/// The relation of a part to the part before it. The part has all rows from slot `from` on, even if the part before has
/// some of them.
struct Continuation {
  /// The number of the part. The record's own file is part 1.
  int part{};
  /// The name of the file that failed. It is in the same folder.
  std::string before;
  /// The first slot of the part.
  std::int64_t from{};
  /// The failure of the file before.
  std::string cause;
};

/// Returns whether the path exists. Returns false if the path cannot be examined.
[[nodiscard]] bool path_exists(const std::string& path);

/// Fails with bad_file if there is a rollback journal next to the file, because another program stopped in the middle
/// of a change. The record's own writer leaves no journal. Readers never roll a journal back, because that overwrites
/// the file and may change other files. `where` names the file in the fault.
[[nodiscard]] Result<void> check_no_journal(const std::string& where, const std::string& file);

/// Returns the file name of a path: "RUN.db" for "/data/RUN.db".
[[nodiscard]] std::string name_in_folder(const std::string& path);

/// Returns the path of a part: "RUN.2.db" for part 2 of "RUN.db". Part 1 is the record itself.
[[nodiscard]] std::string part_path(const std::string& record_path, int part);

/// The record and the number in the name of a part.
struct PartName {
  std::string record;
  /// The number of the part, 2 to 999999.
  int part{};
};
/// Parses the name of a part: "RUN.2.db" gives "RUN.db" and 2. Returns nothing for any other name;
/// "RUN.20261127.db" is a record. Does not look at the file.
[[nodiscard]] std::optional<PartName> part_name(const std::string& path);

/// Returns the path of the ramp run in a folder of `qualify`: "ramp.db", or "rate.db" if only that exists. Version
/// 0.1.0 used the second name.
[[nodiscard]] std::string ramp_record_path(const std::string& folder);

/// Returns the path of the live copy: "RUN.live.db" for "RUN.db".
[[nodiscard]] std::string live_copy_path(const std::string& record_path);
/// Returns whether a file is a live copy: it has the name of a live copy and is a link to one of the numbered files.
[[nodiscard]] bool is_live_copy(const std::string& path);
/// Returns the number in the name of a copy's file: 7 for "RUN.live.db.7" and "RUN.live.db.7-wal". Returns nothing for
/// any other name, such as "RUN.live.db.20261127". `link` is the name of the copy, "RUN.live.db".
[[nodiscard]] std::optional<int> live_copy_number(std::string_view name, std::string_view link);
inline constexpr int kHighestCopyNumber = 9999;  ///< the next number is 1 again
/// Returns the record of a live copy: "RUN.db" for "RUN.live.db", or "RUN" if only that exists. Returns any other path
/// unchanged.
[[nodiscard]] std::string record_of_copy(const std::string& path);

/// Writes a continuation into fresh tables, inside the caller's transaction.
[[nodiscard]] Result<void> write_continuation(Database& database, const Continuation& continuation);
/// Reads the continuation of a part. Returns nothing for the first file of a record. Fails with bad_file if its slot is
/// outside any run.
[[nodiscard]] Result<std::optional<Continuation>> read_continuation(Database& database);

/// One file of a record, or the live copy of one.
struct Part {
  std::string path;
  bool is_live_copy{};
  Continuation continuation;
};

/// The files that a record consists of.
struct RecordFiles {
  /// The path of the record itself.
  std::string path;
  /// Equal in every part.
  std::string run_id;
  /// At least one part, in the order of the run. The record's own file continues nothing.
  std::vector<Part> parts;
  /// The fault of the first part that is not in `parts`, because it is missing or unreadable.
  std::optional<Fault> lost;
  /// The path of the part that continues the part in `lost`; empty if none is lost.
  std::string follows_lost;
};
/// Examines every file next to the record that has the name of a part, even if numbers are missing. Ignores files of
/// another run and files without rows. A live copy is a record of one file. Fails with bad_file if the record is
/// missing; with storage if a program is writing a file of this run, or if the last part is damaged.
[[nodiscard]] Result<RecordFiles> find_record_files(const std::string& record_path);

/// Opens one file of a record for reading and checks it with check_schema(). The file is untrusted: opening it changes
/// neither the file nor any file next to it, and no writer can start while it is open. Opens a live copy as
/// open_live_copy() does. Fails with bad_file if the file is not a record or has a journal next to it, and with storage
/// if it is being written or is damaged.
[[nodiscard]] Result<Database> open_part(const Part& part);
/// Opens one file by its path, as open_part() does.
[[nodiscard]] Result<Database> open_record(const std::string& path);
/// Opens a live copy, given its path or the path of its record. The connection can be read again while the copy grows.
/// Fails with bad_file if the copy is missing, with storage if it cannot be read.
[[nodiscard]] Result<Database> open_live_copy(const std::string& path);

/// Returns the paths of all records in a folder, including records of which only a status file remains. Leaves out live
/// copies and parts. Includes a part whose record is missing, and every file with its own status file, which a part
/// never has. Does not open any record.
[[nodiscard]] std::set<std::string> list_records(const std::string& folder);

/// Returns the reserved ending of a file that belongs to a record: ".status" for "RUN.db.status". Returns an empty text
/// for other names.
[[nodiscard]] std::string_view reserved_ending(std::string_view path);

/// Fails with storage if a new record must not have this name: the file exists, parts of a record of this name exist,
/// a moved record of this name left its log, its safe-state file or the status file of its unfinished run behind, an
/// existing record has a part of this name, or the name has a reserved ending. Fails with usage if the name is that of
/// another kind of file, such as a table.
[[nodiscard]] Result<void> check_name_of_new_record(const std::string& path);

/// Returns the first part number above `present` for which neither a part nor a status file exists. Part numbers
/// therefore increase during a run, even if a file was removed.
[[nodiscard]] int next_part(const std::string& record_path, int present);

}  // namespace gyrotherm::record
