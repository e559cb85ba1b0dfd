// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/record_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "acquisition/record/row.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/status_file.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::record {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLive = ".live.db";
constexpr int kReaderPatienceMs = 0;  // a writer does not finish soon
constexpr int kPatienceBesideMs = 2000;

/// Parses ".2" as a part number: 1 to 6 digits without a leading zero. A longer number may be a date.
std::optional<int> part_number_in(std::string_view ending) {
  constexpr std::size_t kMaxDigits = 6;
  if (!ending.starts_with('.') || ending.size() > 1 + kMaxDigits || ending.substr(1, 1) == "0") return {};
  ending.remove_prefix(1);
  int number{};
  const auto read = std::from_chars(ending.data(), ending.data() + ending.size(), number);
  const bool is_number = read.ec == std::errc() && read.ptr == ending.data() + ending.size();
  return is_number && number > 1 ? std::optional(number) : std::nullopt;
}

}  // namespace

bool path_exists(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error);
}

Result<void> check_no_journal(const std::string& where, const std::string& file) {
  const auto journal = file + "-journal";
  std::error_code error;
  if (!fs::exists(fs::symlink_status(journal, error))) return {};
  return failure(FaultKind::bad_file, where,
                 fmt::format("there is a journal next to it ({}): another program was interrupted while it changed the "
                             "record, and the journal is not applied here",
                             name_in_folder(journal)));
}

std::string name_in_folder(const std::string& path) { return fs::path(path).filename().string(); }

std::string part_path(const std::string& record_path, int part) {
  if (part == 1) return record_path;
  fs::path path(record_path);
  const auto extension = path.extension().string();
  path.replace_extension();
  return fmt::format("{}.{}{}", path.string(), part, extension);
}

std::optional<PartName> part_name(const std::string& path) {
  const fs::path whole(path);
  const auto stem = whole.stem(), extension = whole.extension();
  // "RUN.2.db", or "RUN.2" for a record without an extension.
  for (const auto& [ending, own] :
       {std::pair(stem.extension(), stem.stem().string() + extension.string()), std::pair(extension, stem.string())})
    if (const auto number = part_number_in(ending.string());
        number && part_path(own, *number) == whole.filename().string())
      return PartName{.record = (whole.parent_path() / own).string(), .part = *number};
  return std::nullopt;
}

std::string ramp_record_path(const std::string& folder) {
  const auto path = folder + "/ramp.db", former = folder + "/rate.db";
  return !path_exists(path) && path_exists(former) ? former : path;
}

std::string live_copy_path(const std::string& record_path) {
  constexpr std::string_view kEnding = ".db";
  const auto stem =
      record_path.ends_with(kEnding) ? record_path.substr(0, record_path.size() - kEnding.size()) : record_path;
  return stem + std::string(kLive);
}

std::optional<int> live_copy_number(std::string_view name, std::string_view link) {
  if (!name.starts_with(link) || name.substr(link.size(), 1) != ".") return {};
  name.remove_prefix(link.size() + 1);
  int number{};
  const auto read = std::from_chars(name.data(), name.data() + name.size(), number);
  if (read.ec != std::errc() || name.front() == '0' || number < 1 || number > kHighestCopyNumber) return {};
  const auto rest = name.substr(static_cast<std::size_t>(read.ptr - name.data()));
  return rest.empty() || rest == "-wal" || rest == "-shm" ? std::optional(number) : std::nullopt;
}

bool is_live_copy(const std::string& path) {
  std::error_code none_there;
  if (!path.ends_with(kLive) || !fs::is_symlink(fs::symlink_status(path, none_there))) return false;
  const auto target = fs::read_symlink(path, none_there).string();
  return live_copy_number(target, name_in_folder(path)).has_value();
}

std::string record_of_copy(const std::string& path) {
  if (!is_live_copy(path)) return path;
  const auto stem = path.substr(0, path.size() - kLive.size());
  const auto record = fmt::format("{}.db", stem);
  std::error_code none_there;
  return !path_exists(record) && fs::is_regular_file(stem, none_there) ? stem : record;
}

Result<void> write_continuation(Database& database, const Continuation& continuation) {
  auto insert = database.prepare("INSERT INTO meta(key, value) VALUES(?, ?)");
  if (!insert) return failure(insert.error());
  return insert->run("part", continuation.part)
      .and_then([&] { return insert->run("continues", plain(continuation.before)); })
      .and_then([&] { return insert->run("continues_from", continuation.from); })
      .and_then([&] { return insert->run("continues_cause", plain(continuation.cause)); });
}

Result<std::optional<Continuation>> read_continuation(Database& database) {
  const auto row = database.first_row(
      "SELECT (SELECT value FROM meta WHERE key = 'part'), (SELECT value FROM meta WHERE key = 'continues'),"
      " (SELECT value FROM meta WHERE key = 'continues_from'), (SELECT value FROM meta WHERE key = 'continues_cause')");
  if (!row) return failure(row.error());
  if (!*row || (*row)->null(0)) return std::nullopt;
  if (const auto from = (*row)->integer(2); from < 0 || from > kMaxSlots + 1)
    return failure(FaultKind::bad_file, database.path(), "a part of a record continues from an impossible second");
  return Continuation{.part = static_cast<int>((*row)->integer(0)),
                      .before = std::string((*row)->text(1)),
                      .from = (*row)->integer(2),
                      .cause = std::string((*row)->text(3))};
}

namespace {

/// Describes a record that does not exist. Proposes a file whose name differs only by ".db".
std::string describe_missing(const std::string& path) {
  std::error_code error;
  const auto with_ending = path + ".db";
  if (fs::is_regular_file(with_ending, error)) return fmt::format("no such file. Did you mean \"{}\"?", with_ending);
  return "no such file, expected a gyrotherm record";
}

Result<Database> open_copy(const std::string& copy) {
  if (!is_live_copy(copy))
    return failure(FaultKind::bad_file, copy,
                   "does not exist: no program is writing the record, or it has only started");
  auto database = Database::open(copy, Access::read_beside, kPatienceBesideMs);
  if (!database) return database;
  // The first read fixes the snapshot of the connection.
  if (auto begun = database->execute("BEGIN; SELECT 1 FROM meta LIMIT 1"); !begun) return failure(begun.error());
  if (auto checked = check_schema(*database, copy); !checked) return failure(checked.error());
  return database;
}

}  // namespace

Result<Database> open_live_copy(const std::string& path) {
  return open_copy(is_live_copy(path) ? path : live_copy_path(path));
}

Result<Database> open_part(const Part& part) {
  if (part.is_live_copy) return open_copy(part.path);
  std::error_code error;
  const auto status = fs::status(part.path, error);
  if (!fs::exists(status)) return failure(FaultKind::bad_file, part.path, describe_missing(part.path));
  if (!fs::is_regular_file(status))
    return failure(FaultKind::bad_file, part.path, "is not a regular file, expected a gyrotherm record");
  auto database = Database::open(part.path, Access::read_only, kReaderPatienceMs);
  if (!database) return database;
  if (auto alone = check_no_journal(part.path, database->path()); !alone) return failure(alone.error());
  if (auto checked = check_schema(*database, part.path); !checked) return failure(checked.error());
  return database;
}

Result<Database> open_record(const std::string& path) {
  return open_part({.path = path, .is_live_copy = is_live_copy(path), .continuation = {}});
}

namespace {

Result<std::string> read_run_id(const Part& part) {
  return open_part(part).and_then([](Database database) { return meta(database, "id"); });
}

struct FoundPart {
  Part part;
  std::string run_id;
};

/// Reads the description of a part. Fails with bad_file if the file is not part `number` of a run.
Result<FoundPart> find_part(const std::string& path, int number) {
  auto database = open_record(path);
  if (!database) return failure(database.error());
  auto id = meta(*database, "id");
  if (!id) return failure(id.error());
  auto continuation = read_continuation(*database);
  if (!continuation) return failure(continuation.error());
  if (!*continuation || (*continuation)->part != number)
    return failure(FaultKind::bad_file, path, "is not a part of the record");
  const auto events = database->query_integer("SELECT count(*) FROM event", 0);
  if (!events) return failure(events.error());
  if (*events == 0)
    return failure(FaultKind::bad_file, path, "is empty: its writer ended before it wrote the first event");
  return FoundPart{.part = {.path = path, .continuation = std::move(**continuation)}, .run_id = std::move(*id)};
}

/// Returns the run's id from the status file of a record; empty if there is no status file.
std::string run_id_in_status_file(const std::string& path) {
  const auto status = read_status_file_if_any(path);
  return status ? status->id : std::string();
}

/// Returns whether a file that cannot be read belongs to another run, as its status file shows. Parts have no status
/// file.
bool is_of_another_run(const std::string& path, const std::string& run_id) {
  const auto its_run = run_id_in_status_file(path);
  return !its_run.empty() && its_run != run_id;
}

/// Returns the numbers of all files next to a record that have the name of a part. If the folder cannot be listed,
/// finds them up to the first missing number.
std::set<int> find_part_numbers(const std::string& record_path) {
  std::set<int> numbers;
  const auto own = name_in_folder(record_path), beginning = fs::path(own).stem().string() + ".";
  for (const auto& entry : list_folder(parent_folder(record_path))) {
    const auto file = entry.filename().string();
    if (!file.starts_with(beginning)) continue;  // true for most files
    if (const auto name = part_name(file); name && name->record == own) numbers.insert(name->part);
  }
  for (int number = 2; path_exists(part_path(record_path, number)); ++number) numbers.insert(number);
  return numbers;
}

/// Returns the number of the file that a part continues. If all files were renamed, the part stores the old name of
/// that file. An old name such as "A.2.db" may be the name of the record itself. It is treated as the name of a part
/// only if its number is lower than the number of the continuing part.
int find_continued_number(const Continuation& continuation, const std::string& record_path) {
  if (continuation.before == name_in_folder(record_path)) return 1;
  const auto name = part_name(continuation.before);
  if (!name) return 1;
  return name->record == name_in_folder(record_path) || name->part < continuation.part ? name->part : 1;
}

/// Returns the first slot after a part and its predecessors, or 0 if it is unknown.
std::int64_t end_slot(const Part& part) {
  const auto last = open_part(part).and_then([](Database database) { return last_slot(database); });
  return std::max(part.continuation.from, last.value_or(-1) + 1);
}

/// Finds the first part that continues a lost file, which is not among the parts before it. Ignores a part if the parts
/// before it have every slot before its first slot, because it then has all rows of the lost file.
void find_lost_part(RecordFiles& files, const std::string& record_path, const std::map<int, Fault>& rejected) {
  std::set<int> before;
  for (std::size_t i = 0; i < files.parts.size(); ++i) {
    const auto& continuation = files.parts[i].continuation;
    const int wanted = find_continued_number(continuation, record_path);
    if (i > 0 && !before.contains(wanted) && end_slot(files.parts[i - 1]) < continuation.from) {
      const auto lost = part_path(record_path, wanted);
      const auto known = rejected.find(wanted);
      const auto* why = path_exists(lost) ? "is not the file from which the record continued"
                                          : "no such file, expected a part of the record";
      files.lost = known != rejected.end() ? known->second : Fault{FaultKind::bad_file, lost, why};
      files.follows_lost = files.parts[i].path;
      return;
    }
    before.insert(continuation.part);
  }
}

}  // namespace

Result<RecordFiles> find_record_files(const std::string& record_path) {
  const Part first{.path = record_path,
                   .is_live_copy = is_live_copy(record_path),
                   .continuation = {.part = 1, .before = {}, .cause = {}}};
  RecordFiles files;
  files.path = record_path;
  /// The reasons why files are not parts, by their numbers.
  std::map<int, Fault> rejected;
  /// The last damaged file so far.
  std::optional<Fault> damaged;
  const auto own = read_run_id(first);
  if (own)
    files.parts.push_back(first);
  else if (is_locked(own.error()))
    return failure(own.error());
  else
    files.lost = own.error();
  files.run_id = own ? *own : run_id_in_status_file(record_path);
  for (const int number : find_part_numbers(record_path)) {
    const auto path = part_path(record_path, number);
    auto found = find_part(path, number);
    if (!found) {
      rejected.emplace(number, found.error());
      if (found.error().kind == FaultKind::bad_file || is_of_another_run(path, files.run_id)) continue;
      if (is_locked(found.error())) return failure(found.error());
      damaged = found.error();
      continue;
    }
    if (files.parts.empty()) files.run_id = found->run_id;  // the first file is lost
    if (found->run_id != files.run_id) {
      rejected.emplace(number, Fault{FaultKind::bad_file, path, "belongs to another run"});
      continue;
    }
    damaged.reset();  // the run continued there
    files.parts.push_back(std::move(found->part));
  }
  if (damaged) return failure(*damaged);
  if (files.parts.empty()) return failure(*files.lost);
  // Sort by slot: a number may have been reused for a later file.
  std::ranges::stable_sort(files.parts, {}, [](const Part& part) { return part.continuation.from; });
  if (files.lost)
    files.follows_lost = files.parts.front().path;
  else
    find_lost_part(files, record_path, rejected);
  return files;
}

namespace {

bool is_record_name(const fs::path& path) {
  if (path.extension() != ".db") return false;
  if (path.stem().extension() == ".live") return false;
  const auto part = part_name(path.string());
  const auto has_status_file = [](const std::string& record) { return path_exists(status_path(record)); };
  return !part || has_status_file(path.string()) || (!path_exists(part->record) && !has_status_file(part->record));
}

}  // namespace

std::set<std::string> list_records(const std::string& folder) {
  std::set<std::string> records;
  for (const auto& path : list_folder(folder)) {
    auto text = path.string();
    if (text.ends_with(".db.status")) text.resize(text.size() - std::string_view(".status").size());
    if (is_record_name(text)) records.insert(text);
  }
  return records;
}

std::string_view reserved_ending(std::string_view path) {
  for (const std::string_view ending : {"-wal", "-shm", "-journal", ".status", ".socket", ".safe-state", ".made-safe",
                                        ".ask-operator", ".sha256", ".live.db"})
    if (path.ends_with(ending)) return ending;
  return {};
}

namespace {

/// Returns whether a status file belongs to an unfinished run with acknowledged seconds, or cannot be read.
bool is_needed_by_run(const std::string& record_path) {
  if (!path_exists(status_path(record_path))) return false;
  const auto status = read_status_file_if_any(record_path);
  return !status || (!status->finished && status->acknowledged >= 0);
}

/// Returns the names of files that another record of this name left behind and that a new record would replace.
std::vector<std::string> find_files_left_behind(const std::string& record_path) {
  std::vector<std::string> names;
  for (const auto* ending : {"-wal", ".safe-state"})
    if (path_exists(record_path + ending)) names.push_back(name_in_folder(record_path + ending));
  if (is_needed_by_run(record_path)) names.push_back(name_in_folder(status_path(record_path)));
  return names;
}

}  // namespace

Result<void> check_name_of_new_record(const std::string& path) {
  const auto refuse = [&](const std::string& why) { return failure(FaultKind::storage, path, why); };
  if (std::error_code error; path.ends_with('/') || fs::is_directory(path, error))
    return failure(FaultKind::usage, path, "is a folder, expected the name of a record, which ends in .db");
  static const std::set<std::string> others{".csv", ".tsv",  ".txt", ".xlsx", ".json", ".toml", ".nc",
                                            ".svg", ".html", ".pdf", ".xml",  ".c",    ".gp"};
  const bool is_other = others.contains(fs::path(path).extension().string());
  if (path_exists(path))
    return refuse(is_other ? "exists already and is not a record, expected a new name that ends in .db"
                           : "exists already, and a record is never overwritten");
  if (is_other)
    return failure(
        FaultKind::usage, path,
        "is not the name of a record, expected one that ends in .db; \"gyrotherm export\" makes a table of it");
  if (const auto ending = reserved_ending(path); !ending.empty())
    return refuse(fmt::format("files next to a record end with {}, expected another name", ending));
  const auto files = find_record_files(path);
  if (files)
    return refuse(
        fmt::format("its run continues in {}, and a record is never overwritten; \"gyrotherm resume {}\" resumes it",
                    files->parts.front().path, path));
  if (files.error().kind != FaultKind::bad_file) return failure(files.error());
  if (const auto left = find_files_left_behind(path); !left.empty())
    return refuse(fmt::format(
        "a record of this name was moved or removed without {}, which a new record would replace; move all files of a "
        "record together, or choose another name",
        fmt::join(left, " and ")));
  const auto name = part_name(path);
  const auto whole = name ? find_record_files(name->record) : files;
  if (!whole && whole.error().kind == FaultKind::bad_file) return {};
  return refuse(fmt::format("is the name of a continuation file of {}, expected another name", name->record));
}

int next_part(const std::string& record_path, int present) {
  const auto is_taken = [](const std::string& path) {
    std::error_code error;
    // The status file of an older record with that name would be attributed to the part.
    return fs::exists(fs::symlink_status(path, error)) || path_exists(status_path(path));
  };
  int number = present + 1;
  while (is_taken(part_path(record_path, number))) ++number;
  return number;
}

}  // namespace gyrotherm::record
