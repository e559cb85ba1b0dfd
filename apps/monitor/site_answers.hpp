// SPDX-License-Identifier: Apache-2.0
/// Routes each path to the part that answers it: the page, run data, the site, or commands to a run.
#pragma once

#include <string>

#include "apps/monitor/access_control.hpp"
#include "apps/monitor/run_answers.hpp"
#include "apps/monitor/run_catalogue.hpp"
#include "apps/monitor/sessions.hpp"
#include "apps/monitor/site_overview.hpp"
#include "apps/monitor/web.hpp"
#include "core/clock.hpp"

namespace gyrotherm::monitor {

/// Sends commands from the page to a run, through the same socket as `gyrotherm tell`, on behalf of the page's user. A
/// command that ends the run must be confirmed. Usable from any thread.
class RunControl {
 public:
  RunControl(AccessControl& access, const RunCatalogue& catalogue, const Clock& clock)
      : access_(access), catalogue_(catalogue), confirmations_(clock) {}

  /// Answers POST /api/v1/runs/KEY/VERB with {"text", "alarm", "time", "confirm"}. The verb is pause, resume, stop,
  /// abort, note, acknowledge, shelve or unshelve. For stop, abort and shelve, the text is the reason. Without a valid
  /// "confirm", stop and abort change nothing: the answer is 409, with the progress of the run and a token, valid for
  /// 30 s, that confirms the command. If "confirm" is not valid, the answer has an "error", too.
  [[nodiscard]] WebAnswer answer(const WebRequest& request, const std::string& key, const std::string& verb);

 private:
  [[nodiscard]] WebAnswer request_confirmation(const Sender& sender, const FoundRun& run, const std::string& verb,
                                               bool has_confirmed);

  AccessControl& access_;
  const RunCatalogue& catalogue_;
  Confirmations confirmations_;
};

/// Answers all requests. Usable from any thread.
class SiteAnswers {
 public:
  /// `site` is null for a monitor without a site file.
  SiteAnswers(AccessControl& access, RunAnswers& runs, RunControl& control, const RunCatalogue& catalogue,
              const RunFeed& feed, SiteOverview* site)
      : access_(access), runs_(runs), control_(control), catalogue_(catalogue), feed_(feed), site_(site) {}

  [[nodiscard]] WebAnswer answer(const WebRequest& request);

 private:
  [[nodiscard]] WebAnswer answer_get(const WebRequest& request);
  [[nodiscard]] WebAnswer answer_post(const WebRequest& request);

  AccessControl& access_;
  RunAnswers& runs_;
  RunControl& control_;
  const RunCatalogue& catalogue_;
  const RunFeed& feed_;
  SiteOverview* site_;
};

}  // namespace gyrotherm::monitor
