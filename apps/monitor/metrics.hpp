// SPDX-License-Identifier: Apache-2.0
/// Where the runs stand, as Prometheus reads it (text format 0.0.4).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/monitor/run_catalogue.hpp"

namespace gyrotherm::monitor {

/// What a monitor says of itself.
struct OwnFigures {
  int watchers{};
  std::size_t cache_bytes{};
};
/// Of runs that go on; of those whose program is silent, or that are to go on and have none, only that it is so, the
/// last second and the alarms; and how the last run of a rig ended, if it was aborted or has alarms that nobody
/// acknowledged, until the next one begins there. Others only count. `runs` are in the order of RunCatalogue::runs().
[[nodiscard]] std::string metrics_text(const std::vector<FoundRun>& runs, const OwnFigures& own);

}  // namespace gyrotherm::monitor
