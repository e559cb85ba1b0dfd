// SPDX-License-Identifier: Apache-2.0
#include "monitor/run_catalogue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/run_parts.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::monitor {
namespace {

namespace fs = std::filesystem;

/// "soak.db" is; "soak.live.db" and "soak.2.db", which belong to it, are not, unless there is no such record.
bool names_a_record(const fs::path& path) {
  if (path.extension() != ".db") return false;
  const auto stem = path.stem();
  const auto inner = stem.extension().string();
  if (inner.empty()) return true;
  const bool part =
      inner.size() > 1 && std::all_of(inner.begin() + 1, inner.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (inner != ".live" && !part) return true;
  const auto whole = path.parent_path() / (stem.stem().string() + ".db");
  return part && !record::is_there(whole.string()) && !record::is_there(whole.string() + ".status");
}

/// The status that the program which carries the run out has written less than kSilentAfter ago, so that nobody needs
/// to try whether the record is free.
std::optional<record::RunStatus> fresh_status(const std::string& path) {
  const auto file = record::status_path(path);
  const auto text = read_text_file_if_any(file, kLargestText, Links::refused);
  if (!text || !*text) return std::nullopt;
  auto status = record::parse_status(**text, file);
  if (!status || status->finished) return std::nullopt;
  const auto age = record::age_of(*status);
  if (!age || *age > record::kSilentAfter) return std::nullopt;
  status->being_written = true;
  status->path = path;
  return *status;
}

}  // namespace

bool FoundRun::is_running() const { return status.being_written && !status.finished; }

bool FoundRun::is_silent() const { return is_running() && (!age_s || *age_s > to_seconds(record::kSilentAfter)); }

bool FoundRun::was_left() const {
  return trouble.empty() && !is_running() && !status.finished && !(info && info->imported) &&
         status.standing.state < RunState::aborting;
}

RunCatalogue::RunCatalogue(std::vector<std::string> folders) : folders_(std::move(folders)) {}

RunCatalogue::Stamp RunCatalogue::stamp_of(const std::string& path) {
  return {.status = state_of(record::status_path(path)),
          .record = state_of(path),
          .log = state_of(path + "-wal"),
          .live_copy = identity_of(record::live_copy_path(path))};
}

void RunCatalogue::look_at(const std::string& path) {
  const auto stamp = stamp_of(path);
  Entry entry;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = entries_.find(path); found != entries_.end()) entry = found->second;
  }
  auto& run = entry.run;
  const bool was_silent = run.is_silent();
  const auto age = record::age_of(run.status);
  run.age_s = run.is_running() && age ? std::optional(to_seconds(*age)) : std::nullopt;
  const bool must_read = entry.stamp != stamp || run.is_silent() != was_silent || run.key.empty() || run.is_silent();
  if (must_read) {
    const auto before = run;
    run.path = path;
    run.key = sha256(path).substr(0, 16);
    run.name = fs::path(path).stem().string();
    auto fresh = fresh_status(path);
    auto status = fresh ? Result<record::RunStatus>(std::move(*fresh)) : record::read_status(path);
    run.trouble = status ? std::string() : text(status.error());
    if (status) run.status = std::move(*status);
    if (const auto now = record::age_of(run.status); run.is_running() && now) run.age_s = to_seconds(*now);
    if (!run.trouble.empty() && before.key.empty()) run.status.path = path;
    if (entry.info_of != run.status.id || !entry.info) {
      const auto files = source_files(path, run.is_running());
      auto info = files ? read_info(*files) : Result<record::RunInfo>(failure(files.error()));
      entry.info = info ? std::make_shared<const record::RunInfo>(std::move(*info)) : nullptr;
      entry.info_of = info ? run.status.id : std::string();
    }
    run.info = entry.info;
    if (record::to_json(before.status) != record::to_json(run.status) || before.trouble != run.trouble ||
        was_silent != run.is_silent())
      ++run.version;
    entry.stamp = stamp;
  }
  const std::lock_guard lock(mutex_);
  entries_.insert_or_assign(path, std::move(entry));
}

void RunCatalogue::look() {
  std::set<std::string> there;
  for (const auto& folder : folders_)
    for (const auto& path : entries_of(folder)) {
      auto text = path.string();
      if (text.ends_with(".db.status")) text.resize(text.size() - std::string_view(".status").size());
      if (names_a_record(text)) there.insert(text);
    }
  for (const auto& path : there) look_at(path);
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) { return !there.contains(entry.first); });
}

std::vector<FoundRun> RunCatalogue::runs() const {
  std::vector<FoundRun> runs;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [path, entry] : entries_) runs.push_back(entry.run);
  }
  const auto started = [](const FoundRun& run) { return run.info ? run.info->started_utc : Duration{}; };
  std::ranges::stable_sort(runs, [&](const FoundRun& a, const FoundRun& b) {
    return std::pair(!a.is_running(), -started(a)) < std::pair(!b.is_running(), -started(b));
  });
  return runs;
}

std::optional<FoundRun> RunCatalogue::find(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [path, entry] : entries_)
    if (entry.run.key == key) return entry.run;
  return std::nullopt;
}

}  // namespace gyrotherm::monitor
