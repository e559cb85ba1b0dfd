// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/run_catalogue.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>

#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_source.hpp"
#include "apps/monitor/series.hpp"
#include "core/rig_defaults.hpp"
#include "core/sha256.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::monitor {

namespace fs = std::filesystem;

namespace {

/// During a long scan, the active runs of the folder are updated at this interval. Otherwise they would appear silent.
constexpr auto kActiveRunInterval = std::chrono::seconds(1);

/// Returns whether decisions have added segments since the description of the run was read.
bool has_grown(const record::RunInfo& info, const record::RunStatus& status) {
  return info.goal && static_cast<int>(info.segments.size()) < status.segment_count;
}

/// Clears the texts of embedded files that the page does not use. They can take half a megabyte per run.
void drop_unused_texts(record::RunInfo& info) {
  std::vector texts{&info.rig_text, &info.chamber_map_text, &info.gyro_model_text};
  for (auto& text : info.analogue_map_texts) texts.push_back(&text);
  for (auto& text : info.thermometer_texts) texts.push_back(&text);
  for (auto& text : info.supply_texts) texts.push_back(&text);
  for (auto& unit : info.units) texts.push_back(&unit.stream_text);
  if (info.goal) texts.insert(texts.end(), {&info.goal->mission_text, &info.goal->prior_text});
  for (auto* text : texts) {
    text->clear();
    text->shrink_to_fit();
  }
}

/// Sets `chamber_after_stop`, `chamber_after_abort` and `safe_observe` from the rig file.
void read_end_states(FoundRun& run, const record::RunInfo& info) {
  run.chamber_after_stop = run.chamber_after_abort = "the chamber is made safe";
  run.safe_observe = kUsualObserve;
  const auto rig = TomlTable::parse(info.rig_text, "rig");
  if (!rig) return;
  const auto safe = rig->table("safe"), chamber = rig->table("chamber");
  run.safe_observe = safe.duration("observe", kUsualObserve);
  const bool is_in_safe_table = safe.has("set_point");
  if (is_in_safe_table || chamber.has("safe_set_point")) {
    const auto set_point = is_in_safe_table ? safe.celsius("set_point") : chamber.celsius("safe_set_point");
    run.chamber_after_abort = fmt::format("the chamber is sent to its safe set point, {:g} °C{}", set_point.value,
                                          safe.boolean("off", false) ? ", and switched off" : "");
  }
  const bool holds = safe.text("on_stop", "safe") == "hold";
  run.chamber_after_stop = holds ? "the chamber holds its present set point" : run.chamber_after_abort;
}

/// Returns which channels have a value in the first rows of a record.
Result<std::vector<bool>> find_channels_with_values(const std::vector<SeriesChannel>& channels,
                                                    const record::RecordFiles& files, std::int64_t rows) {
  constexpr std::size_t kChannelsPerQuery = 500;
  std::vector<bool> has_values(channels.size());
  for (std::size_t first = 0; first < channels.size(); first += kChannelsPerQuery) {
    const auto end = std::min(first + kChannelsPerQuery, channels.size());
    std::string columns;
    for (auto i = first; i < end; ++i)
      columns += fmt::format("{}max({} IS NOT NULL)", i > first ? ", " : "", channels[i].sql);
    const auto read = record::each_row(files, {.what = columns, .last = rows - 1}, [&](const record::Statement& row) {
      for (auto i = first; i < end; ++i)
        if (row.integer(static_cast<int>(i - first)) != 0) has_values[i] = true;
      return true;
    });
    if (!read) return failure(read.error());
  }
  return has_values;
}

/// Returns the names of the channels of an imported record that have no value. Does not search a long record, because
/// the scan of a folder must not take long: it returns only the channels of the chamber, which no import fills.
std::vector<std::string> find_channels_without_values(const record::RunInfo& info, const record::RecordFiles& files,
                                                      std::int64_t rows) {
  constexpr std::int64_t kMaxRowsToSearch = 100'000;
  constexpr std::size_t kChamberChannels = 3;
  auto channels = series_channels(info);
  if (rows > kMaxRowsToSearch) channels.erase(channels.begin() + kChamberChannels, channels.end());
  const auto has_values = find_channels_with_values(channels, files, kMaxRowsToSearch);
  std::vector<std::string> names;
  for (std::size_t i = 0; has_values && i < channels.size(); ++i)
    if (!(*has_values)[i]) names.push_back(channels[i].name);
  return names;
}

/// Returns the time of the last row of an imported record; 0 if it cannot be read.
Duration read_imported_length(const record::RecordFiles& files, std::int64_t last_row) {
  Duration length{};
  (void)record::each_row(files, {.what = "monotonic_ns", .first = last_row, .last = last_row},
                         [&](const record::Statement& row) {
                           length = Duration(row.integer(0));
                           return true;
                         });
  return length;
}

/// Returns the age of the last status file of an unfinished run.
std::optional<double> compute_age_s(const FoundRun& run) {
  const auto age = run.is_running() || run.is_abandoned() ? record::status_age(run.status) : std::nullopt;
  return age ? std::optional(to_seconds(*age)) : std::nullopt;
}

void set_names(FoundRun& run, const std::string& path) {
  run.path = run.status.path = path;
  run.key = sha256(path).substr(0, 16);
  run.name = fs::path(path).stem().string();
}

/// Copies the write time of the last status file to the status of a run that no program executes.
void copy_write_time(FoundRun& run) {
  const auto last = record::read_status_file_if_any(run.path);
  if (!last || last->id != run.status.id) return;
  run.status.written_utc = last->written_utc;
  run.status.written_since_boot = last->written_since_boot;
  run.status.written_in_boot = last->written_in_boot;
}

std::string safe_trace_path(const std::string& record) { return record + ".made-safe"; }

/// Reads the trace of gyrotherm-make-safe. Returns nothing if there is none, or if it cannot be read.
std::optional<SafeTrace> read_safe_trace(const std::string& record) {
  const auto path = safe_trace_path(record);
  const auto text = read_text_file_if_any(path, kLargestText, Links::refused);
  const auto table = text && *text ? TomlTable::parse(**text, path) : failure(FaultKind::bad_file, path, "no trace");
  if (!table) return std::nullopt;
  table->expect("schema", "gyrotherm-made-safe/1");
  for (const auto* unused : {"at", "because", "details", "relay", "by"}) table->ignore(unused);
  const SafeTrace trace{.at = Duration(table->integer("utc_ns")),
                        .set_point = {table->number("set_point_c")},
                        .confirmed = table->boolean("confirmed"),
                        .given_up = !table->text("given_up", "").empty()};
  return table->verdict() ? std::optional(trace) : std::nullopt;
}

/// Reads the status of a run and computes its age. If the status cannot be read, keeps the last one and sets
/// `read_error`.
void read_status(FoundRun& run) {
  auto fresh = record::read_fresh_status(run.path);
  auto status = fresh ? Result<record::RunStatus>(std::move(*fresh)) : record::read_status(run.path);
  run.read_error = status ? std::string() : text(status.error());
  if (status) run.status = std::move(*status);
  const bool is_abandoned = run.is_abandoned();
  if (is_abandoned) copy_write_time(run);
  run.safe_trace = is_abandoned ? read_safe_trace(run.path) : std::nullopt;
  run.age_s = compute_age_s(run);
}

/// Returns whether the status, the trace of gyrotherm-make-safe or the read error has changed.
bool is_changed(const FoundRun& before, const FoundRun& now) {
  return before.read_error != now.read_error || before.safe_trace != now.safe_trace ||
         record::to_json(before.status) != record::to_json(now.status);
}

/// Returns the free space on the disk of a folder.
std::optional<std::uint64_t> read_free_bytes(const std::string& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0) return std::nullopt;
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

/// Removes duplicate folders. Ignores slashes at the end of a path. Two threads must not scan the same folder.
std::vector<std::string> remove_duplicates(std::vector<std::string> folders) {
  for (auto& folder : folders)
    while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
  std::set<std::string> seen;
  std::erase_if(folders, [&](const std::string& folder) { return !seen.insert(folder).second; });
  return folders;
}

}  // namespace

bool FoundRun::is_running() const { return status.being_written && !status.finished; }

bool FoundRun::is_silent() const { return is_running() && (!age_s || *age_s > to_seconds(record::kSilentAfter)); }

bool FoundRun::is_abandoned() const {
  return read_error.empty() && !is_running() && !status.finished && !(info && info->imported) &&
         status.overview.state <= RunState::aborting;
}

Duration FoundRun::length() const { return imported_length.value_or(kSecond * (status.slot + 1)); }

RunCatalogue::RunCatalogue(std::vector<std::string> folders) : folders_(remove_duplicates(std::move(folders))) {}

RunCatalogue::FileStates RunCatalogue::read_file_states(const std::string& path) {
  return {.status = read_file_state(record::status_path(path)),
          .record = read_file_state(path),
          .log = read_file_state(path + "-wal"),
          .live_copy = read_file_identity(record::live_copy_path(path)),
          .safe_trace = read_file_state(safe_trace_path(path))};
}

RunCatalogue::Entry RunCatalogue::copy_entry(const std::string& path) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(path);
  return found != entries_.end() ? found->second : Entry{};
}

/// Reads the header of the run's record into `entry`. While the record of a new run is being created, its header is not
/// final; `info_id` stays empty, so the next scan reads it again.
void RunCatalogue::read_info(Entry& entry) {
  auto& run = entry.run;
  const auto files = record::find_source_files(run.path, run.is_running());
  const bool is_final = !run.is_running() || (files && record::has_begun(*files).value_or(false));
  auto info = files ? record::read_source_info(*files) : Result<record::RunInfo>(failure(files.error()));
  entry.info_id = info && is_final ? run.status.id : std::string();
  if (info) read_end_states(run, *info);
  run.standard = info ? record::find_named_history(*info, run.path) : std::nullopt;
  run.imported_length.reset();
  run.channels_without_values.clear();
  if (info && info->imported) {
    run.imported_length = read_imported_length(*files, run.status.slot);
    run.channels_without_values = find_channels_without_values(*info, *files, run.status.slot + 1);
  }
  if (info) drop_unused_texts(*info);
  entry.info = info ? std::make_shared<const record::RunInfo>(std::move(*info)) : nullptr;
}

/// Updates the entry of a record. Reads the files only if they have changed since the last scan, or if the run is or
/// was silent.
void RunCatalogue::scan_record(const std::string& path, const std::string& folder,
                               std::optional<std::uint64_t> free_bytes) {
  // Read before the content of the files, so a change in between is detected at the next scan.
  const auto file_states = read_file_states(path);
  auto entry = copy_entry(path);
  auto& run = entry.run;
  const bool is_new = run.key.empty();
  const bool was_silent = run.is_silent();
  entry.folder = folder;
  run.free_bytes = free_bytes;
  run.age_s = compute_age_s(run);
  if (is_new || entry.file_states != file_states || was_silent || run.is_silent()) {
    const auto before = run;
    if (is_new) set_names(run, path);
    read_status(run);
    if (!entry.info || entry.info_id != run.status.id || has_grown(*entry.info, run.status)) read_info(entry);
    run.info = entry.info;
    if (is_changed(before, run) || was_silent != run.is_silent()) ++run.version;
    entry.file_states = file_states;
  }
  const std::lock_guard lock(mutex_);
  entries_.insert_or_assign(path, std::move(entry));
}

std::vector<std::string> RunCatalogue::active_records_in(const std::string& folder) const {
  std::vector<std::string> paths;
  const std::lock_guard lock(mutex_);
  for (const auto& [path, entry] : entries_)
    if (entry.folder == folder && entry.run.is_running()) paths.push_back(path);
  return paths;
}

void RunCatalogue::scan_folder(const std::string& folder, const std::function<bool()>& is_stopping) {
  const auto records = record::list_records(folder);
  const auto free_bytes = read_free_bytes(folder);
  auto active_runs_updated = std::chrono::steady_clock::now();
  for (const auto& path : records) {
    if (is_stopping()) return;
    scan_record(path, folder, free_bytes);
    if (std::chrono::steady_clock::now() - active_runs_updated < kActiveRunInterval) continue;
    for (const auto& running : active_records_in(folder)) scan_record(running, folder, free_bytes);
    active_runs_updated = std::chrono::steady_clock::now();
  }
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) {
    const auto& [path, found] = entry;
    return found.folder == folder && !records.contains(path);
  });
}

void RunCatalogue::scan(const std::function<bool()>& is_stopping) {
  for (const auto& folder : folders_) scan_folder(folder, is_stopping);
}

/// Returns the run with its present age. Bit 0 of the version is set if the run has become silent since the last scan;
/// the other bits count the changes.
FoundRun RunCatalogue::update_age(FoundRun run) {
  const bool was_silent = run.is_silent();
  run.age_s = compute_age_s(run);
  run.version = 2 * run.version + (run.is_silent() != was_silent ? 1 : 0);
  return run;
}

std::vector<FoundRun> RunCatalogue::runs() const {
  std::vector<FoundRun> runs;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [path, entry] : entries_) runs.push_back(update_age(entry.run));
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
    if (entry.run.key == key) return update_age(entry.run);
  return std::nullopt;
}

}  // namespace gyrotherm::monitor
