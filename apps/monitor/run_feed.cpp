// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/run_feed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquisition/record/run_source.hpp"
#include "apps/monitor/series.hpp"
#include "core/json.hpp"

namespace gyrotherm::monitor {
namespace {

/// Largest number of rows per read.
constexpr std::int64_t kMaxRowsPerRead = 300;
/// Rows of a run kept in memory.
constexpr std::size_t kRowsInMemory = 300;
constexpr double kNsPerMs = 1e6;
constexpr auto kRecheckInterval = std::chrono::milliseconds(200);

std::string format_number(double value) { return std::isfinite(value) ? fmt::format("{:.7g}", value) : "null"; }

std::string sample_text(const record::Statement& row, std::size_t channels) {
  auto text =
      fmt::format(R"({{"slot":{},"utc_ms":{},"segment":{},"phase":{},"in_segment_s":{:.0f},"state":{},"values":[)",
                  row.integer(0), row.null(1) ? "null" : fmt::format("{:.0f}", row.real(1) / kNsPerMs),
                  row.null(2) ? "null" : std::to_string(row.integer(2)), json_text(Json(std::string(row.text(3)))),
                  row.null(4) ? 0 : row.real(4) / 1e9, json_text(Json(std::string(row.text(5)))));
  constexpr int kLeadingColumns = 6;
  for (std::size_t i = 0; i < channels; ++i)
    text += (i > 0 ? "," : "") + format_number(row.real(kLeadingColumns + static_cast<int>(i)));
  return text + "]}";
}

std::string sample_columns(const std::vector<SeriesChannel>& channels) {
  std::string columns = "slot, utc_ns, segment, phase, in_segment_ns, state";
  for (const auto& channel : channels) columns += ", " + channel.sql;
  return columns;
}

Json text_or_null(const record::Statement& row, int column) {
  return row.null(column) ? Json(nullptr) : Json(std::string(row.text(column)));
}

/// Returns an event as JSON. The slot of an event of an imported record is a row number, so its time is added.
std::string event_text(const record::Statement& row, bool imported) {
  Json json{{"number", row.integer(0)},
            {"slot", row.integer(1)},
            {"utc_ms", std::llround(row.real(2) / kNsPerMs)},
            {"kind", row.text(3)},
            {"interlock", text_or_null(row, 4)},
            {"reaction", text_or_null(row, 5)},
            {"segment", row.null(6) ? Json(nullptr) : Json(row.integer(6))},
            {"channel", text_or_null(row, 7)},
            {"text", std::string(row.text(8))}};
  if (imported) json["time_s"] = to_seconds(Duration(row.integer(9)));
  return json_text(json);
}

/// Returns the start of a run. The start of an imported record without dates is unknown.
Json started_ms(const FoundRun& run) {
  if (!run.info || (run.info->imported && run.info->started_utc == Duration{})) return nullptr;
  return run.info->started_utc.count() / 1'000'000;
}

/// Returns the UTC time at the end of the status' slot, on the clock of the samples, or null if the run has no dates.
/// The clock of a virtual run is virtual. That of a real run may have been set since the start; the status file then
/// has the present time.
Json slot_end_utc_ms(const FoundRun& run) {
  constexpr Duration kClockWasSet = std::chrono::seconds(30);
  if (started_ms(run).is_null()) return nullptr;
  const auto counted = run.info->started_utc + run.length(), written = run.status.written_utc;
  const bool has_own_clock = run.is_running() && !run.info->virtual_rig && written > Duration{};
  const bool was_set = has_own_clock && std::chrono::abs(written - counted) > kClockWasSet;
  return (was_set ? written : counted).count() / 1'000'000;
}

/// Returns the trace of gyrotherm-make-safe, or null.
Json safe_trace_json(const FoundRun& run) {
  const auto& trace = run.safe_trace;
  if (!trace) return nullptr;
  return {{"utc_ms", trace->at.count() / 1'000'000},
          {"set_point_c", trace->set_point.value},
          {"confirmed", trace->confirmed},
          {"given_up", trace->given_up}};
}

/// Returns a message of an event stream. A negative id is omitted.
std::string format_message(const char* kind, const std::string& data, std::int64_t id) {
  const auto line = id < 0 ? std::string() : fmt::format("id: {}\n", id);
  return fmt::format("event: {}\n{}data: {}\n\n", kind, line, data);
}

/// Returns the last slot in the files that can be read now. The live copy of a fast run ends before its status.
std::optional<std::int64_t> read_newest_slot(const FoundRun& run) {
  std::optional<std::int64_t> newest;
  const auto files = record::find_source_files(run.path, run.is_running());
  if (!files) return newest;
  const auto read = record::each_row(*files, {.what = "slot", .table = "(SELECT max(slot) AS slot FROM sample)"},
                                     [&](const record::Statement& row) {
                                       if (!row.null(0)) newest = std::max(newest.value_or(-1), row.integer(0));
                                       return true;
                                     });
  return read ? newest : std::nullopt;
}

}  // namespace

Result<std::vector<FeedRow>> read_samples_after(const FoundRun& run, std::int64_t slot, std::int64_t max_rows) {
  std::vector<FeedRow> rows;
  if (!run.info) return rows;
  const auto files = record::find_source_files(run.path, run.is_running());
  if (!files) return failure(files.error());
  const auto channels = series_channels(*run.info);
  const auto read = record::each_row(*files, {.what = sample_columns(channels), .first = slot + 1, .most = max_rows},
                                     [&](const record::Statement& row) {
                                       rows.push_back({row.integer(0), sample_text(row, channels.size())});
                                       return true;
                                     });
  return read.map([&] { return std::move(rows); });
}

Result<std::vector<FeedRow>> read_events_after(const FoundRun& run, std::int64_t number, std::int64_t max_rows) {
  std::vector<FeedRow> rows;
  const auto files = record::find_source_files(run.path, run.is_running());
  if (!files) return failure(files.error());
  const bool imported = run.info && run.info->imported;
  const record::RowQuery query{
      .what = "id, slot, utc_ns, kind, interlock, reaction, segment, channel, text, monotonic_ns",
      .table = fmt::format("(SELECT * FROM event WHERE id > {})", number),
      .order = "id",
      .first = -1,
      .most = max_rows};
  const auto read = record::each_row(*files, query, [&](const record::Statement& row) {
    rows.push_back({row.integer(0), event_text(row, imported)});
    return true;
  });
  return read.map([&] { return std::move(rows); });
}

std::string status_text(const FoundRun& run) {
  auto json = Json::parse(record::to_json(run.status));
  for (const auto* internal : {"schema", "written_utc_ns", "written_since_boot_ns", "written_in_boot",
                               "slot_since_boot_ns", "slot_in_boot", "path", "pid"})
    json.erase(internal);
  json["key"] = run.key;
  json["name"] = run.name;
  json["running"] = run.is_running();
  json["silent"] = run.is_silent();
  json["age_s"] = run.age_s ? Json(*run.age_s) : Json(nullptr);
  json["made_safe"] = safe_trace_json(run);
  json["trouble"] = run.read_error;
  json["profile"] = run.info ? run.info->profile_name : "";
  json["rig"] = run.info ? run.info->rig_name : "";
  json["started_ms"] = started_ms(run);
  json["utc_ms"] = slot_end_utc_ms(run);
  json["imported"] = run.info && run.info->imported;
  json["length_s"] = to_seconds(run.length());
  return json_text(json);
}

RunFeed::Watch::Watch(RunFeed& feed, std::string key) : feed_(feed), key_(std::move(key)) {
  const std::lock_guard lock(feed_.mutex_);
  ++feed_.runs_[key_].watchers;
}

RunFeed::Watch::~Watch() {
  const std::lock_guard lock(feed_.mutex_);
  const auto run = feed_.runs_.find(key_);
  if (run != feed_.runs_.end() && --run->second.watchers <= 0) feed_.runs_.erase(run);
}

std::string RunFeed::Watch::wait_for_messages(FeedPosition& position, Duration timeout) {
  std::string text;
  {
    std::unique_lock lock(feed_.mutex_);
    const auto is_new = [&] {
      const auto& run = feed_.runs_[key_];
      return feed_.stopped_ || run.read.slot > position.slot || run.read.event > position.event ||
             run.status_version != position.status_version || run.id != position.run;
    };
    if (!feed_.changed_.wait_for(lock, timeout, is_new) || feed_.stopped_) return text;
    const auto& run = feed_.runs_[key_];
    if (run.id != position.run && !position.run.empty()) position = {.skips_old_samples = position.skips_old_samples};
    position.run = run.id;
    if (run.status_version != position.status_version) {
      text += format_message("status", run.status, -1);
      position.status_version = run.status_version;
    }
    if (position.skips_old_samples && !run.samples.empty())
      position.slot = std::max(position.slot, run.samples.front().number - 1);
    if (has_all_after(run, position)) return text + next_messages(run, position);
  }
  text += feed_.read_older_messages(key_, position);
  // The rows cannot be read while the live copy is replaced. Waits a moment before the caller tries again.
  if (text.empty()) {
    std::unique_lock lock(feed_.mutex_);
    feed_.changed_.wait_for(lock, kRecheckInterval, [&] { return feed_.stopped_; });
  }
  return text;
}

/// Returns whether all rows after the position are in memory.
bool RunFeed::has_all_after(const Run& run, const FeedPosition& position) {
  const auto follow = [](const std::deque<FeedRow>& rows, std::int64_t last_read, std::int64_t last_sent) {
    return last_read <= last_sent || (!rows.empty() && rows.front().number <= last_sent + 1);
  };
  return follow(run.samples, run.read.slot, position.slot) && follow(run.events, run.read.event, position.event);
}

/// Returns the messages in memory after the position, and advances the position.
std::string RunFeed::next_messages(const Run& run, FeedPosition& position) {
  std::string text;
  for (const auto& event : run.events)
    if (event.number > position.event) text += format_message("event", event.text, -1);
  for (const auto& sample : run.samples)
    if (sample.number > position.slot) text += format_message("sample", sample.text, sample.number);
  position.slot = std::max(position.slot, run.read.slot);
  position.event = std::max(position.event, run.read.event);
  return text;
}

/// Reads the messages after the position from the record, and advances the position. The watcher's thread calls this if
/// the rows are no longer in memory.
std::string RunFeed::read_older_messages(const std::string& key, FeedPosition& position) const {
  std::string text;
  const auto found = catalogue_.find(key);
  if (!found || found->status.id != position.run) return text;
  if (const auto events = read_events_after(*found, position.event, kMaxRowsPerRead))
    for (const auto& event : *events) {
      text += format_message("event", event.text, -1);
      position.event = event.number;
    }
  if (const auto samples = read_samples_after(*found, position.slot, kMaxRowsPerRead))
    for (const auto& sample : *samples) {
      text += format_message("sample", sample.text, sample.number);
      position.slot = sample.number;
    }
  return text;
}

/// Does not hold the mutex while it reads rows, because a slow disk must not delay the watchers.
void RunFeed::read() {
  std::vector<std::string> keys;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, run] : runs_) keys.push_back(key);
  }
  for (const auto& key : keys) {
    const auto found = catalogue_.find(key);
    const auto position = found ? update_status(*found) : std::nullopt;
    auto rows = position ? read_new_rows(*found, *position) : std::nullopt;
    if (rows) add_new_rows(key, std::move(*rows));
  }
}

/// Updates the status of a run for its watchers. Returns the position up to which its rows have been read, or nothing
/// if the run is not watched. If the record of another run has replaced it, reading restarts at the beginning.
std::optional<RunFeed::ReadPosition> RunFeed::update_status(const FoundRun& found) {
  const std::lock_guard lock(mutex_);
  const auto watched = runs_.find(found.key);
  if (watched == runs_.end()) return std::nullopt;
  auto& run = watched->second;
  const auto& id = found.status.id;
  if (!id.empty() && id != run.id) run = Run{.watchers = run.watchers, .id = id};
  // Also for a silent run, because its age changes.
  if (run.status_version != found.version || found.is_silent()) {
    run.status_version = found.version;
    run.status = status_text(found);
    changed_.notify_all();
  }
  return run.read;
}

/// Reads the rows after a position. The first read, and a read far behind the run, return only the last rows, because a
/// watcher reads older ones itself. Returns nothing if no rows can follow, or if the record cannot be read now.
std::optional<RunFeed::NewRows> RunFeed::read_new_rows(const FoundRun& found, const ReadPosition& position) {
  const bool has_ended = !found.is_running();
  if (position.is_complete && has_ended && found.status.slot <= position.slot) return std::nullopt;
  const bool is_behind =
      !position.has_begun || found.status.slot - position.slot > static_cast<std::int64_t>(kRowsInMemory);
  const auto newest = is_behind ? read_newest_slot(found) : std::nullopt;
  const auto first_slot =
      std::max(position.slot, newest.value_or(found.status.slot) - static_cast<std::int64_t>(kRowsInMemory) / 2);
  auto samples = read_samples_after(found, first_slot, kMaxRowsPerRead);
  auto events = read_events_after(found, position.event, kMaxRowsPerRead);
  if (!samples || !events) return std::nullopt;
  return NewRows{.samples = std::move(*samples),
                 .events = std::move(*events),
                 .has_run_ended = has_ended,
                 .has_skipped = first_slot > position.slot};
}

/// Stores the last rows of a run in memory and wakes its watchers.
void RunFeed::add_new_rows(const std::string& key, NewRows rows) {
  const std::lock_guard lock(mutex_);
  const auto watched = runs_.find(key);
  if (watched == runs_.end()) return;
  auto& run = watched->second;
  const bool is_empty = rows.samples.empty() && rows.events.empty();
  run.read.is_complete = rows.has_run_ended && is_empty;
  if (run.read.has_begun && is_empty) return;
  run.read.has_begun = true;
  const auto keep = [](std::vector<FeedRow>& from, std::deque<FeedRow>& memory, std::int64_t& last) {
    for (auto& row : from) {
      last = row.number;
      memory.push_back(std::move(row));
    }
    while (memory.size() > kRowsInMemory) memory.pop_front();
  };
  if (rows.has_skipped && !rows.samples.empty()) run.samples.clear();
  keep(rows.samples, run.samples, run.read.slot);
  keep(rows.events, run.events, run.read.event);
  changed_.notify_all();
}

void RunFeed::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

int RunFeed::watchers() const {
  const std::lock_guard lock(mutex_);
  int sum = 0;
  for (const auto& [key, run] : runs_) sum += run.watchers;
  return sum;
}

}  // namespace gyrotherm::monitor
