// SPDX-License-Identifier: Apache-2.0
/// The files that a record consists of: how they are named, which of them are there, and how one is opened to be read.
///
/// A record whose file failed goes on in a second one beside it, and so on; each names the one before. While it is
/// written, a live copy is beside it (live_copy.hpp). find_record_files() finds the files once; whatever reads the
/// record takes what it returned.
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

/// What a part says of the one before. Rows from slot `from` on stand in it, also those that the one before may have.
struct Continuation {
  int part{};          ///< its own number; the record's own file is 1
  std::string before;  ///< name of the file that failed, in the same folder
  std::int64_t from{};
  std::string cause;  ///< how that failed
};

/// Whether a file has that name; one that cannot be looked at counts as not there.
[[nodiscard]] bool is_there(const std::string& path);

/// Fails with bad_file if a journal lies beside the file: another program broke off while it changed it. We leave none,
/// and do not play one back, for it overwrites the file and may name others. `where` names the file in the fault.
[[nodiscard]] Result<void> check_no_journal(const std::string& where, const std::string& file);

/// "/data/RUN.db" → "RUN.db".
[[nodiscard]] std::string name_in_folder(const std::string& path);

/// "RUN.db" → "RUN.2.db"; part 1 is the record itself.
[[nodiscard]] std::string part_path(const std::string& record_path, int part);

/// What the name of a file says of it.
struct PartName {
  std::string record;  ///< the path of the record
  int part{};          ///< 2 to 999999
};
/// The way back, by the name alone: "RUN.2.db" → "RUN.db" and 2; nothing of a name that no part has. "RUN.20261127.db"
/// is the name of a record of its own.
[[nodiscard]] std::optional<PartName> part_name(const std::string& path);

/// "RUN.db" → "RUN.live.db".
[[nodiscard]] std::string live_copy_path(const std::string& record_path);
/// Whether a file is a live copy, by its name and by what stands there.
[[nodiscard]] bool is_live_copy(const std::string& path);
/// A file of a copy, by its name: the number in "RUN.live.db.7", also of "RUN.live.db.7-wal"; nothing of another file,
/// as "RUN.live.db.20261127", which is somebody's. `link` is the name of the copy, "RUN.live.db".
[[nodiscard]] std::optional<int> live_copy_number(std::string_view name, std::string_view link);
inline constexpr int kHighestCopyNumber = 9999;  ///< after it comes 1 again
/// The record that a live copy stands beside: "RUN.live.db" → "RUN.db", or "RUN" where that is the one that is there;
/// another path as it is.
[[nodiscard]] std::string record_of_copy(const std::string& path);

/// Inside the caller's transaction, into fresh tables.
[[nodiscard]] Result<void> write_continuation(Database& database, const Continuation& continuation);
/// Nothing for a record's first file. Fails with bad_file if it says what none can say.
[[nodiscard]] Result<std::optional<Continuation>> read_continuation(Database& database);

/// One file of a record, or the live copy of one.
struct Part {
  std::string path;
  bool is_live_copy{};
  Continuation continuation;
};

/// The files that a record consists of.
struct RecordFiles {
  std::string path;           ///< the record's own
  std::string run_id;         ///< in every part
  std::vector<Part> parts;    ///< in the order of the run, at least one; the record's own file continues nothing
  std::optional<Fault> lost;  ///< why a file is not among them that another goes on from; of the first such file
  std::string follows_lost;   ///< then the file that goes on from it
};
/// Looks at every file beside the record that has the name of a part, whatever numbers are missing in between. A file
/// of such a name that is not of this run is no part of it, nor is one that was begun and not filled. A live copy is a
/// record of one file. Fails with bad_file if there is no record, with storage if a file is being written (but by
/// another run, whose status file lies beside it), or the last part is damaged.
[[nodiscard]] Result<RecordFiles> find_record_files(const std::string& record_path);

/// Opens one file of a record to read it, and checks that it is one (check_schema). It may come from anywhere: nothing
/// in it or beside it changes, comes or goes, and no writer can begin while it is open. A live copy is opened as
/// open_live_copy() does. Fails with bad_file, also if a journal lies beside it; with storage if it is being written or
/// damaged.
[[nodiscard]] Result<Database> open_part(const Part& part);
/// Does the same with one file of which nothing but the path is known.
[[nodiscard]] Result<Database> open_record(const std::string& path);
/// Opens the copy of the record that is being written, or the copy itself. The connection sees it as it is now, as long
/// as it lives. Fails with bad_file if there is none, with storage if it cannot be read.
[[nodiscard]] Result<Database> open_live_copy(const std::string& path);

/// The paths of the records that lie in a folder, also of those that nothing but a status file tells of: "soak.db" is
/// one; "soak.live.db" and "soak.2.db", which belong to it, are not, unless there is no such record, or the latter has
/// a status file of its own, as no part has. Opens none of them.
[[nodiscard]] std::set<std::string> records_in(const std::string& folder);

/// How a name ends that a file beside a record has: ".status" of "RUN.db.status"; empty: none has such a name.
[[nodiscard]] std::string_view ending_beside_a_record(std::string_view path);

/// Fails with storage if a new record cannot have that name: a file has it, a run goes on in a file beside it though
/// its own file is gone, it is the name of a part of a record that is there, or one that a file beside a record has,
/// which would be written over, or taken for that.
[[nodiscard]] Result<void> check_name_of_new_record(const std::string& path);

/// The first number above that of the present part whose name no file and no link has, nor a status file's: numbers
/// rise in the order of the run, also where somebody has taken a file away.
[[nodiscard]] int next_part(const std::string& record_path, int present);

}  // namespace gyrotherm::record
