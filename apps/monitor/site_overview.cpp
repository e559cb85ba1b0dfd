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

constexpr std::array kQuestions{"rigs", "attention", "drift", "outliers", "thermometers", "utilisation"};
/// Limit of rows. The page shows a hint if an answer reaches it: kMaxRows in page/site.js.
constexpr const char* kMaxRows = "5000";
constexpr Duration kAnswerLifetime = std::chrono::seconds(30), kStoreTimeout = std::chrono::seconds(20);
constexpr Duration kRigStatesLifetime = std::chrono::seconds(3), kLiveTimeout = std::chrono::seconds(5);

/// Returns the answer of the store as JSON. Fails like read_program_output().
Result<std::string> query_store(const std::string& question, const std::string& site_file, Duration within) {
  return read_program_output(
      {sibling_program_path("gyrotherm-site"), question, "--json", "--most", kMaxRows, "--site", site_file}, within);
}

/// Adds the time since the answer to the age of each rig's last second.
Json add_age(const std::string& rigs, Duration since) {
  auto list = Json::parse(rigs);
  for (auto& rig : list)
    if (rig.is_object() && rig.contains("age_s") && rig["age_s"].is_number())
      rig["age_s"] = rig["age_s"].get<double>() + to_seconds(since);
  return list;
}

WebAnswer query_pending_answer() {
  WebAnswer answer{
      .status = 503,
      .body = text_of(Json{{"error", "a query to the store is in progress; retry in 1 s"}, {"asking", true}})};
  answer.headers.emplace_back("Retry-After", "1");
  return answer;
}

}  // namespace

WebAnswer SiteOverview::answer(std::string_view rest) {
  if (rest.empty()) return site();
  const auto name = rest.substr(1);
  if (site_file_.empty() || std::ranges::find(kQuestions, name) == kQuestions.end())
    return refusal(404, "unknown question to the site");
  return question(std::string(name));
}

WebAnswer SiteOverview::site() {
  Json site{{"name", name_}, {"store", nullptr}, {"rigs", Json::array()}, {"questions", Json::array()}};
  if (site_file_.empty()) return {.body = text_of(site)};
  const auto now = query_rig_states();
  site["store"] = {{"error", now.error}, {"age_s", nullptr}};
  if (now.answered_at) {
    const auto since = since_boot() - *now.answered_at;
    site["store"]["age_s"] = to_seconds(since);
    site["rigs"] = add_age(now.rigs, since);
  }
  for (const char* question : kQuestions) site["questions"].push_back(question);
  return {.body = text_of(site)};
}

SiteOverview::RigStates SiteOverview::cached_rig_states() const {
  const std::lock_guard lock(cache_mutex_);
  return rig_states_;
}

SiteOverview::RigStates SiteOverview::query_rig_states() {
  const auto is_fresh = [](const RigStates& live) {
    return live.asked_at && since_boot() - *live.asked_at <= kRigStatesLifetime;
  };
  auto before = cached_rig_states();
  if (is_fresh(before)) return before;
  const std::unique_lock lock(rig_states_mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return before;
  if (before = cached_rig_states(); is_fresh(before)) return before;
  const auto json = query_store("live", site_file_, kLiveTimeout);
  const bool is_list = json && Json::parse(*json, nullptr, false).is_array();
  const std::lock_guard cache_lock(cache_mutex_);
  rig_states_.asked_at = since_boot();
  rig_states_.error = is_list ? "" : json ? "the answer of gyrotherm-site is not a list of rigs" : json.error().what;
  if (is_list) {
    rig_states_.rigs = *json;
    rig_states_.answered_at = rig_states_.asked_at;
  }
  return rig_states_;
}

std::optional<SiteOverview::CachedAnswer> SiteOverview::cached_answer(const std::string& name) const {
  const std::lock_guard lock(cache_mutex_);
  const auto found = answers_.find(name);
  return found == answers_.end() ? std::nullopt : std::optional(found->second);
}

/// A store that does not answer blocks only one thread of the page. The failure is kept for a while, so the next
/// request does not block again.
WebAnswer SiteOverview::question(const std::string& name) {
  const auto is_fresh = [](const std::optional<CachedAnswer>& answered) {
    return answered && since_boot() - answered->at <= kAnswerLifetime;
  };
  auto before = cached_answer(name);
  if (is_fresh(before)) return before->answer;
  const std::unique_lock lock(question_mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return before ? before->answer : query_pending_answer();
  if (before = cached_answer(name); is_fresh(before)) return before->answer;
  auto json = query_store(name, site_file_, kStoreTimeout);
  auto answer =
      json ? WebAnswer{.body = std::move(*json)} : refusal(503, "the store does not answer: " + json.error().what);
  const std::lock_guard cache_lock(cache_mutex_);
  answers_[name] = {.answer = answer, .at = since_boot()};
  return answer;
}

}  // namespace gyrotherm::monitor
