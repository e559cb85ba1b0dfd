// SPDX-License-Identifier: Apache-2.0
/// Answers requests about the rigs of a site from the site's store: the present state of each rig, and the results of
/// the queries of gyrotherm-site. That program queries the store, with a time limit. Usable from any thread.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "apps/monitor/web.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::monitor {

/// Returns the message of a failed query on one line: its lines joined by "; ", each without punctuation at its end.
[[nodiscard]] std::string one_line_reason(std::string_view message);

class SiteOverview {
 public:
  /// Creates an overview. `site_file` contains the address of the store; empty if the site has none.
  SiteOverview(std::string name, std::string site_file) : name_(std::move(name)), site_file_(std::move(site_file)) {}

  /// Answers GET /api/v1/site. `subpath` is empty for the lists of rigs and queries, or names a query, such as
  /// "/drift".
  [[nodiscard]] WebAnswer answer(std::string_view subpath);

 private:
  struct CachedAnswer {
    /// Result of a query, or a refusal if it failed.
    WebAnswer answer;
    /// Time of the answer, since the boot of this machine.
    Duration answered_at{};
  };
  /// The last list of rigs from the store. Times are since the boot of this machine.
  struct RigStates {
    std::string rigs = "[]";
    std::optional<Duration> answered_at{};
    std::optional<Duration> queried_at{};
    std::string error{};
  };
  [[nodiscard]] WebAnswer answer_site();
  [[nodiscard]] WebAnswer answer_query(const std::string& name);
  [[nodiscard]] std::optional<CachedAnswer> cached_answer(const std::string& name) const;
  /// Returns the list of rigs. Queries the store first, unless the list is fresh or another thread is querying.
  [[nodiscard]] RigStates query_rig_states();
  [[nodiscard]] RigStates cached_rig_states() const;

  std::string name_;
  std::string site_file_;
  // Held during a query, each by one kind, so a long query does not delay the list of rigs. No thread waits for them.
  std::mutex query_mutex_;
  std::mutex rig_states_mutex_;
  mutable std::mutex cache_mutex_;
  std::map<std::string, CachedAnswer> answers_;
  RigStates rig_states_;
};

}  // namespace gyrotherm::monitor
