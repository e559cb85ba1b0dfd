// SPDX-License-Identifier: Apache-2.0
#include "monitor/run_catalogue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/run_finder.hpp"
#include "acquisition/record/run_source.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::monitor {

namespace fs = std::filesystem;

namespace {

/// Files that the run was carried out with, half a megabyte in all: what is kept of each of many runs is to be small.
void drop_unused_texts(record::RunInfo& info) {
  std::vector texts{&info.rig_text, &info.chamber_map_text, &info.gyro_model_text};
  for (auto& text : info.analogue_map_texts) texts.push_back(&text);
  for (auto& unit : info.units) texts.push_back(&unit.stream_text);
  for (auto* text : texts) {
    text->clear();
    text->shrink_to_fit();
  }
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
  return {.status = record::state_of(record::status_path(path)),
          .record = record::state_of(path),
          .log = record::state_of(path + "-wal"),
          .live_copy = record::identity_of(record::live_copy_path(path))};
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
    auto fresh = record::fresh_status(path);
    auto status = fresh ? Result<record::RunStatus>(std::move(*fresh)) : record::read_status(path);
    run.trouble = status ? std::string() : text(status.error());
    if (status) run.status = std::move(*status);
    if (const auto now = record::age_of(run.status); run.is_running() && now) run.age_s = to_seconds(*now);
    if (!run.trouble.empty() && before.key.empty()) run.status.path = path;
    if (entry.info_of != run.status.id || !entry.info) {
      const auto files = record::source_files(path, run.is_running());
      const bool is_whole = !run.is_running() || (files && record::has_begun(*files).value_or(false));
      auto info = files ? record::read_info(*files) : Result<record::RunInfo>(failure(files.error()));
      entry.info_of = info && is_whole ? run.status.id : std::string();
      if (info) drop_unused_texts(*info);
      entry.info = info ? std::make_shared<const record::RunInfo>(std::move(*info)) : nullptr;
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

void RunCatalogue::look(const std::function<bool()>& is_stopping) {
  std::set<std::string> there;
  for (const auto& folder : folders_) there.merge(record::records_in(folder));
  for (const auto& path : there) {
    if (is_stopping()) return;
    look_at(path);
  }
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
