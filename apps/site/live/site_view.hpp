// SPDX-License-Identifier: Apache-2.0
/// How all rigs of a site are now, as they say themselves over MQTT: for the live page. Any thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/site/live/broker.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// The last status that a rig published.
struct HeardRig {
  std::string name;
  /// Set by the rig itself; cleared by the rig or by the broker in its place.
  bool online{};
  /// Time since the status was published. For a status that the broker had kept it is judged by the UTC in the message.
  Duration age{};
  std::string run;   ///< its run's status as JSON (record::to_json()), "null" where there is none
  std::string left;  ///< … of the last one where none goes on, if that did not end, or with alarms
};

class SiteView {
 public:
  /// Fails as Broker::connect does.
  [[nodiscard]] static Result<std::unique_ptr<SiteView>> connect(const BrokerAddress& address, const std::string& site,
                                                                 std::function<void(const Fault&)> complain);

  [[nodiscard]] bool is_connected() const { return broker_->is_connected(); }
  /// Sorted by topic. A message is ignored if it cannot be read or names another rig than its topic.
  [[nodiscard]] std::vector<HeardRig> rigs() const;

 private:
  SiteView() = default;
  void take(const std::string& site, const Broker::Message& message);

  struct Heard {
    HeardRig rig;
    Duration at{};  ///< since this machine was started
    Duration age_then{};
  };
  mutable std::mutex mutex_;
  std::map<std::string, Heard> heard_;  ///< by topic
  std::unique_ptr<Broker> broker_;      ///< the last, so that it is gone before what it tells of
};

}  // namespace gyrotherm::site
