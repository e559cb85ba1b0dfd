// SPDX-License-Identifier: Apache-2.0
/// Every address of the monitor and what answers there.
#pragma once

#include "apps/monitor/door.hpp"
#include "apps/monitor/run_answers.hpp"
#include "apps/monitor/run_control.hpp"
#include "apps/monitor/site_overview.hpp"
#include "apps/monitor/web.hpp"

namespace gyrotherm::monitor {

/// Any thread.
class SiteAnswers {
 public:
  /// `site` may be null: this monitor knows of no other rigs.
  SiteAnswers(Door& door, RunAnswers& runs, RunControl& control, const RunCatalogue& catalogue, const RunFeed& feed,
              SiteOverview* site)
      : door_(door), runs_(runs), control_(control), catalogue_(catalogue), feed_(feed), site_(site) {}

  [[nodiscard]] WebAnswer answer(const WebRequest& request);

 private:
  [[nodiscard]] WebAnswer look(const WebRequest& request);
  [[nodiscard]] WebAnswer change(const WebRequest& request);

  Door& door_;
  RunAnswers& runs_;
  RunControl& control_;
  const RunCatalogue& catalogue_;
  const RunFeed& feed_;
  SiteOverview* site_;
};

}  // namespace gyrotherm::monitor
