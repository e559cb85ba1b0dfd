// SPDX-License-Identifier: Apache-2.0
/// What the page shows of the other rigs of a site: how each is now, as it says over MQTT, and what the store answers
/// to the site's questions, as the program gyrotherm-site asks them. Any thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "apps/monitor/site_file.hpp"
#include "apps/monitor/web.hpp"
#include "apps/site/live/site_view.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

class SiteOverview {
 public:
  /// `site_file` is what `site` was read from. Fails as SiteView::connect does.
  [[nodiscard]] static Result<std::unique_ptr<SiteOverview>> open(const Site& site, const std::string& site_file,
                                                                  const std::function<void(const Fault&)>& complain);

  /// GET /api/v1/site: `rest` is empty for rigs and questions, "/drift" for the answer to a question.
  [[nodiscard]] WebAnswer answer(std::string_view rest);

 private:
  struct Answered {
    WebAnswer answer;  ///< also that there was none
    Duration at{};     ///< since this machine was started
  };
  SiteOverview(std::string name, std::string site_file) : name_(std::move(name)), site_file_(std::move(site_file)) {}
  [[nodiscard]] WebAnswer rigs() const;
  [[nodiscard]] WebAnswer question(const std::string& name);
  [[nodiscard]] std::optional<Answered> known(const std::string& name) const;

  std::string name_;
  std::string site_file_;  ///< of a site with a store; empty: it has none
  std::unique_ptr<site::SiteView> view_;
  std::mutex asking_;           ///< one question at a time; nobody waits for it
  mutable std::mutex knowing_;  ///< of the answers
  std::map<std::string, Answered> answers_;
};

}  // namespace gyrotherm::monitor
