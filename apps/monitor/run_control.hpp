// SPDX-License-Identifier: Apache-2.0
/// What people may ask of a run from the page: the words of `gyrotherm tell`, through the same socket, in the name of
/// the page's user. What ends a run is asked for twice.
#pragma once

#include <string>

#include "apps/monitor/door.hpp"
#include "apps/monitor/run_catalogue.hpp"
#include "apps/monitor/sessions.hpp"
#include "apps/monitor/web.hpp"
#include "core/clock.hpp"

namespace gyrotherm::monitor {

/// Any thread.
class RunControl {
 public:
  RunControl(Door& door, const RunCatalogue& catalogue, const Clock& clock)
      : door_(door), catalogue_(catalogue), confirmations_(clock) {}

  /// POST /api/v1/runs/KEY/VERB: pause, resume, stop, abort, note or acknowledge, with {"text", "alarm", "confirm"}.
  /// The text of stop and abort is the reason. stop and abort without "confirm" change nothing and are answered with
  /// 409: what they would end, and the word to confirm it with within 30 s.
  [[nodiscard]] WebAnswer answer(const WebRequest& request, const std::string& key, const std::string& verb);

 private:
  [[nodiscard]] WebAnswer ask_back(const Guest& guest, const FoundRun& run, const std::string& verb);

  Door& door_;
  const RunCatalogue& catalogue_;
  Confirmations confirmations_;
};

}  // namespace gyrotherm::monitor
