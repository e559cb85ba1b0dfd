// SPDX-License-Identifier: Apache-2.0
/// Where the runs stand, as Prometheus reads it (text format 0.0.4).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "monitor/run_catalogue.hpp"

namespace gyrotherm::monitor {

/// What a monitor says of itself.
struct OwnFigures {
  int watchers{};
  std::size_t cache_bytes{};
};
/// Of runs that go on, or that are to go on and that no program carries out; others only count.
[[nodiscard]] std::string metrics_text(const std::vector<FoundRun>& runs, const OwnFigures& own);

}  // namespace gyrotherm::monitor
