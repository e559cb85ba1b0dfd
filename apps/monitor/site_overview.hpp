// SPDX-License-Identifier: Apache-2.0
/// Shows the other rigs of a site from the site's store: the present state of each rig, and the answers to the site's
/// questions. The program gyrotherm-site queries the store with a time limit. Usable from any thread.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "apps/monitor/web.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::monitor {

class SiteOverview {
 public:
  /// Creates an overview. `site_file` contains the address of the store; empty if the site has none.
  SiteOverview(std::string name, std::string site_file) : name_(std::move(name)), site_file_(std::move(site_file)) {}

  /// Answers GET /api/v1/site. `rest` is empty for the list of rigs and questions, or the name of a question for its
  /// answer: "/drift".
  [[nodiscard]] WebAnswer answer(std::string_view rest);

 private:
  struct CachedAnswer {
    /// Answer or failure.
    WebAnswer answer;
    /// Time of the answer, measured since the start of this machine.
    Duration at{};
  };
  /// The last list of rigs from the store. Times are since the start of this machine.
  struct RigStates {
    std::string rigs = "[]";
    std::optional<Duration> answered_at{};
    std::optional<Duration> asked_at{};
    std::string error{};
  };
  [[nodiscard]] WebAnswer site();
  [[nodiscard]] WebAnswer question(const std::string& name);
  [[nodiscard]] std::optional<CachedAnswer> cached_answer(const std::string& name) const;
  /// Queries the store unless it was queried a moment ago or a query is in progress. Returns the known list.
  [[nodiscard]] RigStates query_rig_states();
  [[nodiscard]] RigStates cached_rig_states() const;

  std::string name_;
  std::string site_file_;
  /// Held during a query. No thread waits for it.
  std::mutex question_mutex_;
  /// Held during a query for the list of rigs, so that a long question does not delay it. No thread waits for it.
  std::mutex rig_states_mutex_;
  mutable std::mutex cache_mutex_;
  std::map<std::string, CachedAnswer> answers_;
  RigStates rig_states_;
};

}  // namespace gyrotherm::monitor
