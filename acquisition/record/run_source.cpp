// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>

#include "acquisition/record/file_state.hpp"
#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/run_parts.hpp"
#include "acquisition/record/schema.hpp"

namespace gyrotherm::record {
namespace {

constexpr int kLivePatienceMs = 200;

/// The files whose content was looked at.
class SeenFiles {
 public:
  bool has(const std::string& path, const FileState& state) {
    const std::lock_guard lock(mutex_);
    const auto found = files_.find(path);
    return found != files_.end() && found->second == state;
  }
  void add(const std::string& path, const FileState& state) {
    constexpr std::size_t kMost = 4096;
    const std::lock_guard lock(mutex_);
    if (files_.size() >= kMost) files_.clear();
    files_.insert_or_assign(path, state);
  }

 private:
  std::mutex mutex_;
  std::map<std::string, FileState> files_;
};

SeenFiles& seen_files() {
  static SeenFiles seen;
  return seen;
}

}  // namespace

Result<Database> open_source(const SourceFile& file) {
  const auto state = file.live ? identity_of(file.path) : state_of(file.path);
  if (!state.is_there()) return failure(FaultKind::bad_file, file.path, "no such file");
  const bool seen = seen_files().has(file.path, state);
  if (!file.live && !seen) {
    auto opened = open_record(file.path);
    if (opened) seen_files().add(file.path, state);
    return opened;
  }
  auto database =
      Database::open(file.path, file.live ? Access::read_beside : Access::read_only, file.live ? kLivePatienceMs : 0);
  if (!database || seen) return database;
  if (auto checked = check_schema(*database, file.path); !checked) return failure(checked.error());
  seen_files().add(file.path, state);
  return database;
}

namespace {

Result<std::vector<SourceFile>> record_files(const std::string& record_path) {
  const auto parts = files_of_record(record_path);
  if (!parts) return failure(parts.error());
  std::vector<SourceFile> files;
  for (const auto& part : parts->parts) {
    if (!files.empty()) files.back().last = part.continuation.from - 1;
    files.push_back({.path = part.path, .first = part.continuation.from - 1});
  }
  return files;
}

}  // namespace

Result<std::vector<SourceFile>> source_files(const std::string& record_path, bool running) {
  const std::vector live{SourceFile{.path = live_copy_path(record_path), .live = true}};
  std::error_code error;
  const bool has_live = std::filesystem::is_regular_file(live.front().path, error);
  if (running && has_live) return live;
  auto files = record_files(record_path);
  return files || !has_live ? files : live;
}

Result<bool> has_begun(const std::vector<SourceFile>& files) {
  bool begun = false;
  return each_row(files, {.what = "slot", .most = 1}, [&](const Statement&) { return !(begun = true); }).map([&] {
    return begun;
  });
}

Result<RunInfo> read_info(const std::vector<SourceFile>& files) {
  return open_source(files.back()).and_then([](Database database) { return read_run_info(database); });
}

namespace {

/// The rows of one file; false where no more are wanted.
Result<bool> each_row_of(const SourceFile& file, const RowQuery& query, std::int64_t& left,
                         const std::function<bool(const Statement&)>& use) {
  auto database = open_source(file);
  if (!database) return failure(database.error());
  const auto first = std::max(query.first, file.first), last = std::min(query.last, file.last);
  auto rows = database->prepare(fmt::format("SELECT {} FROM {} WHERE {} BETWEEN {} AND {} ORDER BY {} LIMIT {}",
                                            query.what, query.table, query.key, first, last, query.order, left));
  if (!rows) return failure(rows.error());
  for (;;) {
    const auto more = rows->step();
    if (!more) return failure(more.error());
    if (!*more) return left > 0;
    --left;
    if (!use(*rows)) return false;
  }
}

}  // namespace

Result<void> each_row(const std::vector<SourceFile>& files, const RowQuery& query,
                      const std::function<bool(const Statement&)>& use) {
  auto left = query.most;
  for (const auto& file : files) {
    if (file.last < query.first || file.first > query.last || file.first > file.last) continue;
    const auto more = each_row_of(file, query, left, use);
    if (!more) return failure(more.error());
    if (!*more) break;
  }
  return {};
}

}  // namespace gyrotherm::record
