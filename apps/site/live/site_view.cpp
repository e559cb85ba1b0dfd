// SPDX-License-Identifier: Apache-2.0
#include "apps/site/live/site_view.hpp"

#include <algorithm>
#include <ctime>

#include "acquisition/record/status.hpp"
#include "apps/site/live/live_rig.hpp"
#include "core/clock.hpp"
#include "core/json.hpp"

namespace gyrotherm::site {

namespace {

/// A status with as many alarms as may stand (record/alarms.hpp) and a kilobyte for each is none too long.
constexpr std::size_t kLongestMessage = 256'000, kMostRigs = 5000;

/// Reads a UTC as civil_time() writes it.
std::optional<Duration> read_utc(const std::string& text) {
  std::tm time{};
  const char* end = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &time);
  if (end == nullptr || *end != '\0') return std::nullopt;
  return std::chrono::seconds(::timegm(&time));
}

/// Returns the age of a message that the broker had kept, by its UTC and the clock of this machine; zero for a message
/// that was published now, or without a UTC.
Duration age_of_kept(const Broker::Message& message, const std::string& utc) {
  const auto published = read_utc(utc);
  if (!message.kept || !published) return {};
  return std::max(Duration{}, SteadyClock().now().utc - *published);
}

struct StatusMessage {
  HeardRig rig;
  std::string utc;
};

/// Returns the status in a message, or nothing if it is not a status of the rig in its topic. Access lists of a broker
/// are by topic: a rig could publish any name on its own.
std::optional<StatusMessage> read_status_message(const std::string& site, const Broker::Message& message) {
  if (message.text.size() > kLongestMessage) return std::nullopt;
  const auto& text = message.text;
  const auto place = JsonPlace::parse(text, "message");
  if (!place) return std::nullopt;
  HeardRig rig{.name = (*place)["rig"].text(), .online = (*place)["online"].boolean(), .run = "null", .left = "null"};
  const bool fits = (*place)["schema"].text() == kLiveSchema && !rig.name.empty() && place->verdict() &&
                    message.topic == rig_topic(site, rig.name) + "/status";
  if (!fits) return std::nullopt;
  const auto json = Json::parse(text);
  const auto take = [&](const char* key, std::string& status) {
    if (!json.contains(key) || json[key].is_null()) return true;
    status = text_of(json[key]);
    return record::parse_status(status, "message").has_value();
  };
  if (!take("run", rig.run) || !take("left", rig.left)) return std::nullopt;
  const bool has_utc = json.contains("utc") && json["utc"].is_string();
  return StatusMessage{.rig = std::move(rig), .utc = has_utc ? json["utc"].get<std::string>() : ""};
}

}  // namespace

Result<std::unique_ptr<SiteView>> SiteView::connect(const BrokerAddress& address, const std::string& site,
                                                    std::function<void(const Fault&)> complain) {
  std::unique_ptr<SiteView> view(new SiteView);
  auto broker =
      Broker::connect(address, {}, rig_topic(site, "+") + "/status",
                      {.took = [view = view.get(), site](const Broker::Message& message) { view->take(site, message); },
                       .complain = std::move(complain)});
  if (!broker) return failure(broker.error());
  view->broker_ = std::move(*broker);
  return view;
}

void SiteView::take(const std::string& site, const Broker::Message& message) {
  auto status = read_status_message(site, message);
  if (!status) return;
  const auto age = age_of_kept(message, status->utc);
  const std::lock_guard lock(mutex_);
  if (heard_.size() < kMostRigs || heard_.contains(message.topic))
    heard_.insert_or_assign(message.topic, Heard{.rig = std::move(status->rig), .at = since_boot(), .age_then = age});
}

std::vector<HeardRig> SiteView::rigs() const {
  const std::lock_guard lock(mutex_);
  std::vector<HeardRig> rigs;
  for (const auto& [topic, heard] : heard_) {
    rigs.push_back(heard.rig);
    rigs.back().age = since_boot() - heard.at + heard.age_then;
  }
  return rigs;
}

}  // namespace gyrotherm::site
