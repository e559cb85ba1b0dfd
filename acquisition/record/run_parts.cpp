// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_parts.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "acquisition/record/row.hpp"
#include "acquisition/record/run_info.hpp"
#include "core/text.hpp"

namespace gyrotherm::record {
namespace {

struct Found {
  Part part;
  std::string run_id;
};

/// Nothing if the file is no part of a run.
Result<std::optional<Found>> part_at(const std::string& path, int number) {
  auto database = open_record(path);
  if (!database && database.error().kind == FaultKind::bad_file) return std::nullopt;
  if (!database) return failure(database.error());
  auto id = meta(*database, "id");
  if (!id) return failure(id.error());
  auto continuation = read_continuation(*database);
  if (!continuation) return failure(continuation.error());
  if (!*continuation || (*continuation)->part != number) return std::nullopt;
  const auto events = database->ask_integer("SELECT count(*) FROM event", 0);
  if (!events) return failure(events.error());
  if (*events == 0) return std::nullopt;  // its writer died before it could put in what it was begun for
  return Found{.part = {.path = path, .continuation = std::move(**continuation)}, .run_id = std::move(*id)};
}

Result<std::string> run_id_of(const std::string& path) {
  return open_record(path).and_then([](Database database) { return meta(database, "id"); });
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
                             std::filesystem::path(journal).filename().string()));
}

std::string part_path(const std::string& record_path, int part) {
  if (part == 1) return record_path;
  std::filesystem::path path(record_path);
  const auto extension = path.extension().string();
  path.replace_extension();
  return fmt::format("{}.{}{}", path.string(), part, extension);
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
  return Continuation{.part = static_cast<int>((*row)->integer(0)),
                      .before = std::string((*row)->text(1)),
                      .from = (*row)->integer(2),
                      .cause = std::string((*row)->text(3))};
}

Result<RecordFiles> files_of_record(const std::string& record_path) {
  RecordFiles files;
  std::optional<Fault> damaged;  // the last of them, so far
  auto run_id = run_id_of(record_path);
  if (run_id)
    files.parts.push_back({.path = record_path, .continuation = {.part = 1, .before = {}, .cause = {}}});
  else if (is_locked(run_id.error()))
    return failure(run_id.error());
  else
    files.lost = run_id.error();
  for (int number = 2; is_there(part_path(record_path, number)); ++number) {
    auto found = part_at(part_path(record_path, number), number);
    if (!found && is_locked(found.error())) return failure(found.error());
    if (!found) damaged = found.error();
    if (!found || !*found) continue;
    damaged.reset();                                     // the run went on from there
    if (files.parts.empty()) run_id = (*found)->run_id;  // whose own file is lost
    if ((*found)->run_id == *run_id) files.parts.push_back(std::move((*found)->part));
  }
  if (damaged) return failure(*damaged);
  if (files.parts.empty()) return failure(*files.lost);
  return files;
}

Result<int> last_part(const std::string& record_path) {
  return files_of_record(record_path).map([](const RecordFiles& files) {
    return files.parts.back().continuation.part;
  });
}

int next_part(const std::string& record_path) {
  int number = 2;
  while (is_there(part_path(record_path, number))) ++number;
  return number;
}

}  // namespace gyrotherm::record
