// SPDX-License-Identifier: Apache-2.0
/// What a rig says of itself over MQTT, once a second, from status files and live copies: whether it is on, which run
/// is on it, or which one was left there, the second that it measured last, what happened. Topics are
/// gyrotherm/v1/SITE/RIG/{status,sample,event}; the status is kept for those who come later, and is the broker's to
/// change once the rig is gone (last will). Each message is JSON with UTC and a number that counts on. One thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/sqlite.hpp"
#include "acquisition/record/status.hpp"
#include "apps/site/live/broker.hpp"
#include "core/deadline.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

inline constexpr const char* kLiveSchema = "gyrotherm-live/1";

/// "gyrotherm/v1/SITE/RIG"; "+" stands for every rig.
[[nodiscard]] std::string rig_topic(const std::string& site, const std::string& rig);

class LiveRig {
 public:
  struct Name {
    std::string site, rig;
  };
  /// Fails as Broker::connect does.
  [[nodiscard]] static Result<std::unique_ptr<LiveRig>> connect(const BrokerAddress& address, Name name,
                                                                std::function<void(const Fault&)> complain);
  /// Says that the rig is off.
  ~LiveRig();
  LiveRig(const LiveRig&) = delete;
  LiveRig& operator=(const LiveRig&) = delete;

  /// Looks at these records and says what is new. Without a connection nothing is, and nobody waits.
  void look(const std::vector<std::string>& records);

 private:
  explicit LiveRig(Name name) : name_(std::move(name)), topic_(rig_topic(name_.site, name_.rig)) {}
  /// Each as record::to_json() has it; "null": there is none.
  void say_status(const std::string& run, const std::string& left);
  void say_rows(const record::RunStatus& status);
  [[nodiscard]] Result<void> say_sample(record::Database& copy);
  [[nodiscard]] Result<void> say_events(record::Database& copy);

  Name name_;
  std::string topic_;
  std::unique_ptr<Broker> broker_;
  std::atomic<bool> is_new_{true};  ///< the connection: those who listen may have missed something
  std::uint64_t number_{};
  std::string run_{};  ///< of which the rest is
  std::int64_t slot_{-1};
  std::optional<std::int64_t> event_{};
  std::string said_{};  ///< the status, without what changes each second
  Deadline repeat_{Duration{}};
};

}  // namespace gyrotherm::site
