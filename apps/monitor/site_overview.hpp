// SPDX-License-Identifier: Apache-2.0
/// Shows the other rigs of a site, as the store of the site has them: each rig as it is now, and the answers to the
/// site's questions. The program gyrotherm-site asks the store, for a bounded time. Any thread.
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
  /// `site_file` has the address of the store; empty if the site has none.
  SiteOverview(std::string name, std::string site_file) : name_(std::move(name)), site_file_(std::move(site_file)) {}

  /// Answers GET /api/v1/site: `rest` is empty for rigs and questions, "/drift" for the answer to a question.
  [[nodiscard]] WebAnswer answer(std::string_view rest);

 private:
  struct Answered {
    WebAnswer answer;  ///< also a failure
    Duration at{};     ///< since this machine was started
  };
  /// The last list of rigs that the store has returned.
  struct Live {
    std::string rigs = "[]";                ///< JSON
    std::optional<Duration> answered_at{};  ///< since this machine was started
    std::optional<Duration> asked_at{};     ///< since this machine was started
    std::string error{};                    ///< reason of the last failure
  };
  [[nodiscard]] WebAnswer site();
  [[nodiscard]] WebAnswer question(const std::string& name);
  [[nodiscard]] std::optional<Answered> known(const std::string& name) const;
  /// Asks the store unless it was asked a moment ago or is being asked, and returns what is known then.
  [[nodiscard]] Live live();
  [[nodiscard]] Live known_live() const;

  std::string name_;
  std::string site_file_;
  /// Held while a question is asked. No thread waits for it.
  std::mutex asking_;
  /// Held while the list of rigs is asked for, so that a long question does not delay it. No thread waits for it.
  std::mutex asking_live_;
  mutable std::mutex knowing_;  ///< guards the answers
  std::map<std::string, Answered> answers_;
  Live live_;
};

}  // namespace gyrotherm::monitor
