// SPDX-License-Identifier: Apache-2.0
/// Every address of the monitor and what answers there.
#pragma once

#include "monitor/door.hpp"
#include "monitor/run_answers.hpp"
#include "monitor/run_control.hpp"
#include "monitor/web.hpp"

namespace gyrotherm::monitor {

/// Any thread.
class SiteAnswers {
 public:
  SiteAnswers(Door& door, RunAnswers& runs, RunControl& control, const RunCatalogue& catalogue, const RunFeed& feed)
      : door_(door), runs_(runs), control_(control), catalogue_(catalogue), feed_(feed) {}

  [[nodiscard]] WebAnswer answer(const WebRequest& request);

 private:
  [[nodiscard]] WebAnswer look(const WebRequest& request);
  [[nodiscard]] WebAnswer change(const WebRequest& request);

  Door& door_;
  RunAnswers& runs_;
  RunControl& control_;
  const RunCatalogue& catalogue_;
  const RunFeed& feed_;
};

}  // namespace gyrotherm::monitor
