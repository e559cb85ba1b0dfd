// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>

#include "acquisition/record/schema.hpp"
#include "core/file.hpp"

namespace gyrotherm::record {
namespace {

constexpr int kLivePatienceMs = 200;

/// The files whose schema was checked, with their state.
class SeenFiles {
 public:
  bool has(const std::string& path, const FileState& state) {
    const std::lock_guard lock(mutex_);
    const auto found = files_.find(path);
    return found != files_.end() && found->second == state;
  }
  void add(const std::string& path, const FileState& state) {
    constexpr std::size_t kMaxFiles = 4096;
    const std::lock_guard lock(mutex_);
    if (files_.size() >= kMaxFiles) files_.clear();
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

Result<Database> open_source(const Part& part) {
  const auto state = part.is_live_copy ? read_file_identity(part.path) : read_file_state(part.path);
  if (!state.is_there()) return failure(FaultKind::bad_file, part.path, "no such file");
  const bool seen = seen_files().has(part.path, state);
  if (!part.is_live_copy && !seen) {
    auto opened = open_part(part);
    if (opened) seen_files().add(part.path, state);
    return opened;
  }
  auto database = Database::open(part.path, part.is_live_copy ? Access::read_beside : Access::read_only,
                                 part.is_live_copy ? kLivePatienceMs : 0);
  if (!database || seen) return database;
  if (auto checked = check_schema(*database, part.path); !checked) return failure(checked.error());
  seen_files().add(part.path, state);
  return database;
}

Result<RecordFiles> find_source_files(const std::string& record_path, bool running) {
  RecordFiles live;
  live.path = record_path;
  live.parts = {{.path = live_copy_path(record_path), .is_live_copy = true, .continuation = {}}};
  std::error_code error;
  const bool has_live = std::filesystem::is_regular_file(live.parts.front().path, error);
  if (running && has_live) return live;
  auto files = find_record_files(record_path);
  return files || !has_live ? files : live;
}

Result<bool> has_begun(const RecordFiles& files) {
  bool begun = false;
  return each_row(files, {.what = "slot", .most = 1}, [&](const Statement&) { return !(begun = true); }).map([&] {
    return begun;
  });
}

Result<RunInfo> read_source_info(const RecordFiles& files) {
  return open_source(files.parts.back()).and_then([](Database database) { return read_run_info(database); });
}

namespace {

/// The range of slots that is read from a file.
struct Slots {
  std::int64_t first{}, last{};
};

Slots slot_range(const RecordFiles& files, std::size_t part) {
  const auto next = part + 1;
  return {.first = files.parts[part].continuation.from - 1,
          .last = next < files.parts.size() ? files.parts[next].continuation.from - 1 : kNoEnd};
}

/// Calls `use` with the rows of one file. Returns false if no more rows are required.
Result<bool> each_row_in_part(const Part& part, const Slots& slots, const RowQuery& query, std::int64_t& left,
                              const std::function<bool(const Statement&)>& use) {
  auto database = open_source(part);
  if (!database) return failure(database.error());
  const auto first = std::max(query.first, slots.first), last = std::min(query.last, slots.last);
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

Result<void> each_row(const RecordFiles& files, const RowQuery& query,
                      const std::function<bool(const Statement&)>& use) {
  auto left = query.most;
  for (std::size_t i = 0; i < files.parts.size(); ++i) {
    const auto slots = slot_range(files, i);
    if (slots.last < query.first || slots.first > query.last || slots.first > slots.last) continue;
    const auto more = each_row_in_part(files.parts[i], slots, query, left, use);
    if (!more) return failure(more.error());
    if (!*more) break;
  }
  return {};
}

}  // namespace gyrotherm::record
