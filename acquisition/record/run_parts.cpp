// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_parts.hpp"

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

struct Found {
  Part part;
  std::string run_id;
};

/// Fails with bad_file if the file is no part of a run.
Result<Found> part_at(const std::string& path, int number) {
  auto database = open_record(path);
  if (!database) return failure(database.error());
  auto id = meta(*database, "id");
  if (!id) return failure(id.error());
  auto continuation = read_continuation(*database);
  if (!continuation) return failure(continuation.error());
  if (!*continuation || (*continuation)->part != number)
    return failure(FaultKind::bad_file, path, "is no part of the record");
  const auto events = database->ask_integer("SELECT count(*) FROM event", 0);
  if (!events) return failure(events.error());
  if (*events == 0)
    return failure(FaultKind::bad_file, path, "is empty: its writer died before it could put in what it was begun for");
  return Found{.part = {.path = path, .continuation = std::move(**continuation)}, .run_id = std::move(*id)};
}

Result<std::string> run_id_of(const std::string& path) {
  return open_record(path).and_then([](Database database) { return meta(database, "id"); });
}

/// The run that the status file beside a record is of; empty: there is none.
std::string run_told_of(const std::string& path) {
  const auto status = told_status(path);
  return status ? status->id : std::string();
}

/// Whether a file that cannot be looked at is a record of its own: no part has a status file.
bool is_of_another_run(const std::string& path, const std::string& run_id) {
  const auto its_run = run_told_of(path);
  return !its_run.empty() && its_run != run_id;
}

/// A part's number in a file's name, ".2": 1 to 6 digits, for 8 are a date, and no zero before them.
std::optional<int> part_number_in(std::string_view ending) {
  constexpr std::size_t kMostDigits = 6;
  if (!ending.starts_with('.') || ending.size() > 1 + kMostDigits || ending.substr(1, 1) == "0") return {};
  ending.remove_prefix(1);
  int number{};
  const auto read = std::from_chars(ending.data(), ending.data() + ending.size(), number);
  const bool is_number = read.ec == std::errc() && read.ptr == ending.data() + ending.size();
  return is_number && number > 1 ? std::optional(number) : std::nullopt;
}

/// The numbers of all files beside a record that have the name of a part of it. In a folder that cannot be listed they
/// are found as far as none is missing.
std::set<int> numbers_beside(const std::string& record_path) {
  std::set<int> numbers;
  const auto own = name_in_folder(record_path), beginning = std::filesystem::path(own).stem().string() + ".";
  for (const auto& entry : entries_of(folder_of(record_path))) {
    const auto file = entry.filename().string();
    if (!file.starts_with(beginning)) continue;  // as most files do not
    if (const auto name = part_name(file); name && name->record == own) numbers.insert(name->part);
  }
  for (int number = 2; is_there(part_path(record_path, number)); ++number) numbers.insert(number);
  return numbers;
}

/// The number of the file that a part goes on from. Where all files were renamed together, it is that of the old name,
/// which could be that of a record only if it has the part's own number or a higher one.
int number_before(const Continuation& continuation, const std::string& record_path) {
  if (continuation.before == name_in_folder(record_path)) return 1;
  const auto name = part_name(continuation.before);
  if (!name) return 1;
  return name->record == name_in_folder(record_path) || name->part < continuation.part ? name->part : 1;
}

/// The first slot of which a part and those that it goes on from have nothing; 0 where that cannot be known.
std::int64_t end_of(const Part& part) {
  const auto last = open_record(part.path).and_then([](Database database) { return last_slot(database); });
  return std::max(part.continuation.from, last.value_or(-1) + 1);
}

/// Finds the first part that says it goes on from a file which is none of those before it, unless all that came before
/// its first slot is there: it has taken over what stood in that file.
void look_for_lost(RecordFiles& files, const std::string& record_path, const std::map<int, Fault>& no_parts) {
  std::set<int> before;
  for (std::size_t i = 0; i < files.parts.size(); ++i) {
    const auto& [path, continuation] = files.parts[i];
    const int wanted = number_before(continuation, record_path);
    if (i > 0 && !before.contains(wanted) && end_of(files.parts[i - 1]) < continuation.from) {
      const auto lost = part_path(record_path, wanted);
      const auto known = no_parts.find(wanted);
      const auto* why = is_there(lost) ? "is another file than the one of that name that was gone on from"
                                       : "no such file, expected a part of the record";
      files.lost = known != no_parts.end() ? known->second : Fault{FaultKind::bad_file, lost, why};
      files.follows_lost = path;
      return;
    }
    before.insert(continuation.part);
  }
}

}  // namespace

bool is_there(const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

Result<void> check_no_journal(const std::string& where, const std::string& file) {
  const auto journal = file + "-journal";
  std::error_code error;
  if (!std::filesystem::exists(std::filesystem::symlink_status(journal, error))) return {};
  return failure(FaultKind::bad_file, where,
                 fmt::format("a journal lies beside it ({}): another program broke off while it changed the record, "
                             "and it is not played back here",
                             name_in_folder(journal)));
}

std::string name_in_folder(const std::string& path) { return std::filesystem::path(path).filename().string(); }

std::string part_path(const std::string& record_path, int part) {
  if (part == 1) return record_path;
  std::filesystem::path path(record_path);
  const auto extension = path.extension().string();
  path.replace_extension();
  return fmt::format("{}.{}{}", path.string(), part, extension);
}

std::optional<PartName> part_name(const std::string& path) {
  const std::filesystem::path whole(path);
  const auto stem = whole.stem(), extension = whole.extension();
  // "RUN.2.db", and "RUN.2" of a record whose name has no ending.
  for (const auto& [ending, own] :
       {std::pair(stem.extension(), stem.stem().string() + extension.string()), std::pair(extension, stem.string())})
    if (const auto number = part_number_in(ending.string());
        number && part_path(own, *number) == whole.filename().string())
      return PartName{.record = (whole.parent_path() / own).string(), .part = *number};
  return std::nullopt;
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
  if (const auto from = (*row)->integer(2); from < 0 || from > kMostSlots + 1)
    return failure(FaultKind::bad_file, database.path(), "a part of a record goes on from no second of a run");
  return Continuation{.part = static_cast<int>((*row)->integer(0)),
                      .before = std::string((*row)->text(1)),
                      .from = (*row)->integer(2),
                      .cause = std::string((*row)->text(3))};
}

Result<RecordFiles> files_of_record(const std::string& record_path) {
  RecordFiles files;
  std::map<int, Fault> no_parts;  // why a file is none, by its number
  std::optional<Fault> damaged;   // the last of them, so far
  auto own = run_id_of(record_path);
  if (own)
    files.parts.push_back({.path = record_path, .continuation = {.part = 1, .before = {}, .cause = {}}});
  else if (is_locked(own.error()))
    return failure(own.error());
  else
    files.lost = own.error();
  auto run_id = own ? *own : run_told_of(record_path);
  for (const int number : numbers_beside(record_path)) {
    const auto path = part_path(record_path, number);
    auto found = part_at(path, number);
    if (!found) {
      no_parts.emplace(number, found.error());
      if (found.error().kind == FaultKind::bad_file || is_of_another_run(path, run_id)) continue;
      if (is_locked(found.error())) return failure(found.error());
      damaged = found.error();
      continue;
    }
    if (files.parts.empty()) run_id = found->run_id;  // whose own file is lost
    if (found->run_id != run_id) {
      no_parts.emplace(number, Fault{FaultKind::bad_file, path, "is of another run"});
      continue;
    }
    damaged.reset();  // the run went on from there
    files.parts.push_back(std::move(found->part));
  }
  if (damaged) return failure(*damaged);
  if (files.parts.empty()) return failure(*files.lost);
  // Numbers do not tell where one was given anew to a file that came later, as was done once.
  std::ranges::stable_sort(files.parts, {}, [](const Part& part) { return part.continuation.from; });
  if (files.lost)
    files.follows_lost = files.parts.front().path;
  else
    look_for_lost(files, record_path, no_parts);
  return files;
}

Result<int> last_part(const std::string& record_path) {
  return files_of_record(record_path).map([](const RecordFiles& files) {
    return files.parts.back().continuation.part;
  });
}

std::string_view ending_beside_a_record(std::string_view path) {
  for (const std::string_view ending :
       {"-wal", "-shm", "-journal", ".status", ".socket", ".safe-state", ".made-safe", ".sha256", ".live.db"})
    if (path.ends_with(ending)) return ending;
  return {};
}

Result<void> check_name_of_new_record(const std::string& path) {
  const auto refuse = [&](const std::string& why) { return failure(FaultKind::storage, path, why); };
  if (is_there(path)) return refuse("exists already, and a record is never overwritten");
  if (const auto ending = ending_beside_a_record(path); !ending.empty())
    return refuse(fmt::format("files that stand beside a record end with {}, expected another name", ending));
  const auto files = files_of_record(path);
  if (files)
    return refuse(
        fmt::format("its run went on in {}, and a record is never overwritten; \"gyrotherm resume {}\" goes on",
                    files->parts.front().path, path));
  if (files.error().kind != FaultKind::bad_file) return failure(files.error());
  const auto name = part_name(path);
  const auto whole = name ? files_of_record(name->record) : files;
  if (!whole && whole.error().kind == FaultKind::bad_file) return {};
  return refuse(fmt::format("is the name of a file that {} would go on in, expected one of its own", name->record));
}

int next_part(const std::string& record_path, int present) {
  const auto is_taken = [](const std::string& path) {
    std::error_code error;
    // A status file that somebody's record of that name has left would speak for the part.
    return std::filesystem::exists(std::filesystem::symlink_status(path, error)) || is_there(status_path(path));
  };
  int number = present + 1;
  while (is_taken(part_path(record_path, number))) ++number;
  return number;
}

}  // namespace gyrotherm::record
