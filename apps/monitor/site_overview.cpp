// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/site_overview.hpp"

#include <algorithm>
#include <array>

#include "core/clock.hpp"
#include "core/command.hpp"
#include "core/json.hpp"
#include "core/process.hpp"

namespace gyrotherm::monitor {

namespace {

constexpr std::array kQuestions{"rigs", "attention", "drift", "outliers", "thermometers", "utilisation"};
/// As many as rigs that a SiteView has. The page says that there may be more where an answer has so many: kMostRows in
/// page/site.js.
constexpr const char* kMostRows = "5000";
constexpr Duration kFresh = std::chrono::seconds(30), kPatienceWithStore = std::chrono::seconds(20);

Json json_of_rig(const site::HeardRig& rig) {
  return {{"rig", rig.name},
          {"online", rig.online},
          {"age_s", to_seconds(rig.age)},
          {"run", Json::parse(rig.run)},
          {"left", Json::parse(rig.left)}};
}

WebAnswer being_asked() {
  WebAnswer answer{.status = 503, .body = text_of(Json{{"error", "the store is being asked"}, {"asking", true}})};
  answer.headers.emplace_back("Retry-After", "1");
  return answer;
}

}  // namespace

Result<std::unique_ptr<SiteOverview>> SiteOverview::open(const Site& site, const std::string& site_file,
                                                         const std::function<void(const Fault&)>& complain) {
  std::unique_ptr<SiteOverview> overview(new SiteOverview(site.name, site.has_store ? site_file : ""));
  if (!site.live) return overview;
  auto view = site::SiteView::connect(*site.live, site.name, complain);
  if (!view) return failure(view.error());
  overview->view_ = std::move(*view);
  return overview;
}

WebAnswer SiteOverview::answer(std::string_view rest) {
  if (rest.empty()) return rigs();
  const auto name = rest.substr(1);
  if (site_file_.empty() || std::ranges::find(kQuestions, name) == kQuestions.end())
    return refusal(404, "the site has no such question");
  return question(std::string(name));
}

WebAnswer SiteOverview::rigs() const {
  Json site{{"name", name_}, {"live", nullptr}, {"rigs", Json::array()}, {"questions", Json::array()}};
  if (view_) {
    site["live"] = {{"connected", view_->is_connected()}};
    for (const auto& rig : view_->rigs()) site["rigs"].push_back(json_of_rig(rig));
  }
  if (!site_file_.empty())
    for (const char* question : kQuestions) site["questions"].push_back(question);
  return {.body = text_of(site)};
}

std::optional<SiteOverview::Answered> SiteOverview::known(const std::string& name) const {
  const std::lock_guard lock(knowing_);
  const auto found = answers_.find(name);
  return found == answers_.end() ? std::nullopt : std::optional(found->second);
}

/// A store that does not answer costs the page one thread, and that not again and again.
WebAnswer SiteOverview::question(const std::string& name) {
  const auto is_fresh = [](const std::optional<Answered>& answered) {
    return answered && since_boot() - answered->at <= kFresh;
  };
  auto before = known(name);
  if (is_fresh(before)) return before->answer;
  const std::unique_lock lock(asking_, std::try_to_lock);
  if (!lock.owns_lock()) return before ? before->answer : being_asked();
  if (before = known(name); is_fresh(before)) return before->answer;
  auto json =
      printed_by({program_beside_this_one("gyrotherm-site"), name, "--json", "--most", kMostRows, "--site", site_file_},
                 kPatienceWithStore);
  auto answer =
      json ? WebAnswer{.body = std::move(*json)} : refusal(503, "the store does not answer: " + json.error().what);
  const std::lock_guard knowing(knowing_);
  answers_[name] = {.answer = answer, .at = since_boot()};
  return answer;
}

}  // namespace gyrotherm::monitor
