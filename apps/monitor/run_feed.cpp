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

constexpr std::int64_t kAtOnce = 300;  ///< rows read in one go
constexpr std::size_t kKept = 300;     ///< rows of a run in memory
constexpr double kNsPerMs = 1e6;
constexpr auto kLookAgain = std::chrono::milliseconds(200);

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.7g}", value) : "null"; }

std::string sample_text(const record::Statement& row, std::size_t channels) {
  auto text =
      fmt::format(R"({{"slot":{},"utc_ms":{},"segment":{},"phase":{},"in_segment_s":{:.0f},"state":{},"values":[)",
                  row.integer(0), row.null(1) ? "null" : fmt::format("{:.0f}", row.real(1) / kNsPerMs),
                  row.null(2) ? "null" : std::to_string(row.integer(2)), text_of(Json(std::string(row.text(3)))),
                  row.null(4) ? 0 : row.real(4) / 1e9, text_of(Json(std::string(row.text(5)))));
  constexpr int kBefore = 6;
  for (std::size_t i = 0; i < channels; ++i)
    text += (i > 0 ? "," : "") + number_text(row.real(kBefore + static_cast<int>(i)));
  return text + "]}";
}

std::string sample_columns(const std::vector<SeriesChannel>& channels) {
  std::string what = "slot, utc_ns, segment, phase, in_segment_ns, state";
  for (const auto& channel : channels) what += ", " + channel.sql;
  return what;
}

Json or_null(const record::Statement& row, int column) {
  return row.null(column) ? Json(nullptr) : Json(std::string(row.text(column)));
}

std::string event_text(const record::Statement& row) {
  return text_of(Json{{"number", row.integer(0)},
                      {"slot", row.integer(1)},
                      {"utc_ms", std::llround(row.real(2) / kNsPerMs)},
                      {"kind", row.text(3)},
                      {"interlock", or_null(row, 4)},
                      {"reaction", or_null(row, 5)},
                      {"segment", row.null(6) ? Json(nullptr) : Json(row.integer(6))},
                      {"channel", or_null(row, 7)},
                      {"text", std::string(row.text(8))}});
}

std::string message(const char* kind, const std::string& data, std::int64_t id) {
  const auto line = id < 0 ? std::string() : fmt::format("id: {}\n", id);
  return fmt::format("event: {}\n{}data: {}\n\n", kind, line, data);
}

}  // namespace

Result<std::vector<FeedRow>> samples_after(const FoundRun& run, std::int64_t slot, std::int64_t most) {
  std::vector<FeedRow> rows;
  if (!run.info) return rows;
  const auto files = record::find_source_files(run.path, run.is_running());
  if (!files) return failure(files.error());
  const auto channels = series_channels(*run.info);
  const auto read = record::each_row(*files, {.what = sample_columns(channels), .first = slot + 1, .most = most},
                                     [&](const record::Statement& row) {
                                       rows.push_back({row.integer(0), sample_text(row, channels.size())});
                                       return true;
                                     });
  return read.map([&] { return std::move(rows); });
}

Result<std::vector<FeedRow>> events_after(const FoundRun& run, std::int64_t number, std::int64_t most) {
  std::vector<FeedRow> rows;
  const auto files = record::find_source_files(run.path, run.is_running());
  if (!files) return failure(files.error());
  const record::RowQuery query{.what = "id, slot, utc_ns, kind, interlock, reaction, segment, channel, text",
                               .table = fmt::format("(SELECT * FROM event WHERE id > {})", number),
                               .order = "id",
                               .first = -1,
                               .most = most};
  const auto read = record::each_row(*files, query, [&](const record::Statement& row) {
    rows.push_back({row.integer(0), event_text(row)});
    return true;
  });
  return read.map([&] { return std::move(rows); });
}

std::string status_text(const FoundRun& run) {
  auto json = Json::parse(record::to_json(run.status));
  for (const auto* internal : {"schema", "written_utc_ns", "written_since_boot_ns", "written_in_boot", "path", "pid"})
    json.erase(internal);
  json["key"] = run.key;
  json["name"] = run.name;
  json["running"] = run.is_running();
  json["silent"] = run.is_silent();
  json["age_s"] = run.age_s ? Json(*run.age_s) : Json(nullptr);
  json["trouble"] = run.trouble;
  json["profile"] = run.info ? run.info->profile_name : "";
  json["rig"] = run.info ? run.info->rig_name : "";
  json["started_ms"] = run.info ? Json(run.info->started_utc.count() / 1'000'000) : Json(nullptr);
  json["imported"] = run.info && run.info->imported;
  return text_of(json);
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

std::string RunFeed::Watch::next(FeedPlace& place, Duration patience) {
  std::string text;
  std::unique_lock lock(feed_.mutex_);
  const auto is_new = [&] {
    const auto& run = feed_.runs_[key_];
    return feed_.stopped_ || run.slot > place.slot || run.event > place.event ||
           run.status_version != place.status_version || run.id != place.run;
  };
  if (!feed_.something_.wait_for(lock, patience, is_new) || feed_.stopped_) return text;
  const auto& run = feed_.runs_[key_];
  if (run.id != place.run && !place.run.empty()) place = {};
  place.run = run.id;
  if (run.status_version != place.status_version) {
    text += message("status", run.status, -1);
    place.status_version = run.status_version;
  }
  const bool missed_samples =
      run.slot > place.slot && (run.samples.empty() || run.samples.front().number > place.slot + 1);
  const bool missed_events =
      run.event > place.event && (run.events.empty() || run.events.front().number > place.event + 1);
  if (!missed_samples && !missed_events) {
    for (const auto& event : run.events)
      if (event.number > place.event) text += message("event", event.text, -1);
    for (const auto& sample : run.samples)
      if (sample.number > place.slot) text += message("sample", sample.text, sample.number);
    place.slot = std::max(place.slot, run.slot);
    place.event = std::max(place.event, run.event);
    return text;
  }
  lock.unlock();
  text += feed_.missed(key_, place);
  if (!text.empty()) return text;
  lock.lock();  // the copy is being made anew
  feed_.something_.wait_for(lock, kLookAgain, [&] { return feed_.stopped_; });
  return text;
}

std::string RunFeed::missed(const std::string& key, FeedPlace& place) const {
  std::string text;
  const auto found = catalogue_.find(key);
  if (!found || found->status.id != place.run) return text;
  if (const auto events = events_after(*found, place.event, kAtOnce))
    for (const auto& event : *events) {
      text += message("event", event.text, -1);
      place.event = event.number;
    }
  if (const auto samples = samples_after(*found, place.slot, kAtOnce))
    for (const auto& sample : *samples) {
      text += message("sample", sample.text, sample.number);
      place.slot = sample.number;
    }
  return text;
}

void RunFeed::read() {
  std::vector<std::string> keys;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, run] : runs_) keys.push_back(key);
  }
  for (const auto& key : keys) read(key);
}

/// The last rows first, when a run begins to be watched: who wants older ones says so.
void RunFeed::read(const std::string& key) {
  const auto found = catalogue_.find(key);
  if (!found) return;
  std::int64_t slot = -1, event = -1;
  bool begun = false, read_whole = false;
  {
    const std::lock_guard lock(mutex_);
    const auto run = runs_.find(key);
    if (run == runs_.end()) return;
    // Another run's record in its place begins at its own start, however far the one before had come.
    const auto& id = found->status.id;
    if (!id.empty() && id != run->second.id) run->second = Run{.watchers = run->second.watchers, .id = id};
    slot = run->second.slot;
    event = run->second.event;
    begun = run->second.begun;
    read_whole = run->second.read_whole;
    if (run->second.status_version != found->version || found->is_silent()) {  // whose age alone changes
      run->second.status_version = found->version;
      run->second.status = status_text(*found);
      something_.notify_all();
    }
  }
  const bool over = !found->is_running();
  if (read_whole && over && found->status.slot <= slot) return;
  if (!begun) slot = std::max<std::int64_t>(-1, found->status.slot - static_cast<std::int64_t>(kKept) / 2);
  auto samples = samples_after(*found, slot, kAtOnce);
  auto events = events_after(*found, event, kAtOnce);
  if (!samples || !events) return;
  const bool nothing_new = samples->empty() && events->empty();
  const std::lock_guard lock(mutex_);
  const auto place = runs_.find(key);
  if (place == runs_.end()) return;
  auto& run = place->second;
  run.read_whole = over && nothing_new;
  if (begun && nothing_new) return;
  run.begun = true;
  for (auto& row : *samples) {
    run.slot = row.number;
    run.samples.push_back(std::move(row));
  }
  for (auto& row : *events) {
    run.event = row.number;
    run.events.push_back(std::move(row));
  }
  while (run.samples.size() > kKept) run.samples.pop_front();
  while (run.events.size() > kKept) run.events.pop_front();
  something_.notify_all();
}

void RunFeed::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  something_.notify_all();
}

int RunFeed::watchers() const {
  const std::lock_guard lock(mutex_);
  int sum = 0;
  for (const auto& [key, run] : runs_) sum += run.watchers;
  return sum;
}

}  // namespace gyrotherm::monitor
