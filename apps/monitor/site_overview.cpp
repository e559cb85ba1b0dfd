// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/site_overview.hpp"

#include <algorithm>
#include <array>

#include "core/child_process.hpp"
#include "core/clock.hpp"
#include "core/json.hpp"
#include "core/process.hpp"

namespace gyrotherm::monitor {

namespace {

constexpr std::array kQueries{"rigs",          "attention",    "alarms",     "frequent-alarms", "standards",
                              "charts",        "drift",        "outliers",   "yield",           "capability",
                              "recalibration", "thermometers", "utilisation"};
/// Largest number of rows of an answer. The page adds a note if an answer has as many: kMaxRows in page/site.js.
constexpr const char* kMaxRows = "5000";
constexpr Duration kAnswerLifetime = std::chrono::seconds(30), kStoreTimeout = std::chrono::seconds(20);
constexpr Duration kRigStatesLifetime = std::chrono::seconds(3), kLiveTimeout = std::chrono::seconds(5);

/// Largest answer of the store. The rigs that write its texts are not trusted, and the memory of the monitor is
/// limited. 5000 rows of the longest query have 3 MB.
constexpr std::size_t kMaxStoreBytes = 4'000'000;

/// Runs a query of gyrotherm-site and returns its JSON. Fails like read_program_output().
Result<std::string> query_store(const std::string& query, const std::string& site_file, Duration within) {
  return read_program_output(
      {sibling_program_path("gyrotherm-site"), query, "--json", "--most", kMaxRows, "--site", site_file}, within,
      kMaxStoreBytes);
}

/// Adds the time since the answer to the age of each rig's last sample.
Json update_ages(const std::string& rigs, Duration since) {
  auto list = Json::parse(rigs);
  for (auto& rig : list)
    if (rig.is_object() && rig.contains("age_s") && rig["age_s"].is_number())
      rig["age_s"] = rig["age_s"].get<double>() + to_seconds(since);
  return list;
}

WebAnswer make_retry_answer() {
  WebAnswer answer{
      .status = 503,
      .body = json_text(Json{{"error", "a query to the store is in progress; retry in 1 s"}, {"asking", true}})};
  answer.headers.emplace_back("Retry-After", "1");
  return answer;
}

}  // namespace

std::string one_line_reason(std::string_view message) {
  constexpr std::string_view kBlanks = " \t\r\n", kEnd = " \t\r\n.,;:?!";
  std::string reason;
  while (!message.empty()) {
    auto line = message.substr(0, message.find('\n'));
    message.remove_prefix(std::min(line.size() + 1, message.size()));
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    line = line.substr(0, line.find_last_not_of(kEnd) + 1);
    if (!line.empty()) reason += (reason.empty() ? "" : "; ") + std::string(line);
  }
  return reason;
}

WebAnswer SiteOverview::answer(std::string_view subpath) {
  if (subpath.empty()) return answer_site();
  const auto name = subpath.substr(1);
  if (site_file_.empty() || std::ranges::find(kQueries, name) == kQueries.end()) return refusal(404, "unknown query");
  return answer_query(std::string(name));
}

WebAnswer SiteOverview::answer_site() {
  Json site{{"name", name_}, {"store", nullptr}, {"rigs", Json::array()}, {"questions", Json::array()}};
  if (site_file_.empty()) return {.body = json_text(site)};
  const auto now = query_rig_states();
  site["store"] = {{"error", now.error}, {"age_s", nullptr}};
  if (now.answered_at) {
    const auto since = since_boot() - *now.answered_at;
    site["store"]["age_s"] = to_seconds(since);
    site["rigs"] = update_ages(now.rigs, since);
  }
  for (const char* query : kQueries) site["questions"].push_back(query);
  return {.body = json_text(site)};
}

SiteOverview::RigStates SiteOverview::cached_rig_states() const {
  const std::lock_guard lock(cache_mutex_);
  return rig_states_;
}

SiteOverview::RigStates SiteOverview::query_rig_states() {
  const auto is_fresh = [](const RigStates& live) {
    return live.queried_at && since_boot() - *live.queried_at <= kRigStatesLifetime;
  };
  auto cached = cached_rig_states();
  if (is_fresh(cached)) return cached;
  const std::unique_lock lock(rig_states_mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return cached;
  if (cached = cached_rig_states(); is_fresh(cached)) return cached;
  const auto json = query_store("live", site_file_, kLiveTimeout);
  const bool is_list = json && Json::parse(*json, nullptr, false).is_array();
  const std::lock_guard cache_lock(cache_mutex_);
  rig_states_.queried_at = since_boot();
  rig_states_.error = is_list ? ""
                      : json  ? "gyrotherm-site did not return a list of rigs"
                              : one_line_reason(json.error().what);
  if (is_list) {
    rig_states_.rigs = *json;
    rig_states_.answered_at = rig_states_.queried_at;
  }
  return rig_states_;
}

std::optional<SiteOverview::CachedAnswer> SiteOverview::cached_answer(const std::string& name) const {
  const std::lock_guard lock(cache_mutex_);
  const auto found = answers_.find(name);
  return found == answers_.end() ? std::nullopt : std::optional(found->second);
}

/// If the store does not respond, only one thread of the server waits for it. The failure is kept for a while, so the
/// next request does not wait again.
WebAnswer SiteOverview::answer_query(const std::string& name) {
  const auto is_fresh = [](const std::optional<CachedAnswer>& answered) {
    return answered && since_boot() - answered->answered_at <= kAnswerLifetime;
  };
  auto cached = cached_answer(name);
  if (is_fresh(cached)) return cached->answer;
  const std::unique_lock lock(query_mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return cached ? cached->answer : make_retry_answer();
  if (cached = cached_answer(name); is_fresh(cached)) return cached->answer;
  auto json = query_store(name, site_file_, kStoreTimeout);
  auto answer = json ? WebAnswer{.body = std::move(*json)}
                     : refusal(503, "the query to the store failed: " + one_line_reason(json.error().what));
  const std::lock_guard cache_lock(cache_mutex_);
  answers_[name] = {.answer = answer, .answered_at = since_boot()};
  return answer;
}

}  // namespace gyrotherm::monitor
