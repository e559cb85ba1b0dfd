// SPDX-License-Identifier: Apache-2.0
#include "site/live/site_view.hpp"

#include "acquisition/record/status.hpp"
#include "core/clock.hpp"
#include "core/json.hpp"
#include "site/live/live_rig.hpp"

namespace gyrotherm::site {

namespace {

/// A status with as many alarms as may stand (record/alarms.hpp) and a kilobyte for each is none too long.
constexpr std::size_t kLongestMessage = 256'000, kMostRigs = 5000;

/// What a message says; nothing where it is not one of a rig.
std::optional<HeardRig> read_status_message(const std::string& text) {
  if (text.size() > kLongestMessage) return std::nullopt;
  const auto place = JsonPlace::parse(text, "message");
  if (!place) return std::nullopt;
  HeardRig rig{.name = (*place)["rig"].text(), .online = (*place)["online"].boolean(), .run = "null", .left = "null"};
  const bool fits = (*place)["schema"].text() == kLiveSchema && !rig.name.empty() && place->verdict();
  if (!fits) return std::nullopt;
  const auto json = Json::parse(text);
  const auto take = [&](const char* key, std::string& status) {
    if (!json.contains(key) || json[key].is_null()) return true;
    status = text_of(json[key]);
    return record::parse_status(status, "message").has_value();
  };
  return take("run", rig.run) && take("left", rig.left) ? std::optional(rig) : std::nullopt;
}

}  // namespace

Result<std::unique_ptr<SiteView>> SiteView::connect(const BrokerAddress& address, const std::string& site,
                                                    std::function<void(const Fault&)> complain) {
  std::unique_ptr<SiteView> view(new SiteView);
  auto broker = Broker::connect(
      address, {}, rig_topic(site, "+") + "/status",
      {.took = [view = view.get()](const std::string& topic, const std::string& text) { view->take(topic, text); },
       .complain = std::move(complain)});
  if (!broker) return failure(broker.error());
  view->broker_ = std::move(*broker);
  return view;
}

void SiteView::take(const std::string& topic, const std::string& text) {
  auto rig = read_status_message(text);
  if (!rig) return;
  const std::lock_guard lock(mutex_);
  if (heard_.size() < kMostRigs || heard_.contains(topic))
    heard_.insert_or_assign(topic, Heard{.rig = std::move(*rig), .at = since_boot()});
}

std::vector<HeardRig> SiteView::rigs() const {
  const std::lock_guard lock(mutex_);
  std::vector<HeardRig> rigs;
  for (const auto& [topic, heard] : heard_) {
    rigs.push_back(heard.rig);
    rigs.back().age = since_boot() - heard.at;
  }
  return rigs;
}

}  // namespace gyrotherm::site
