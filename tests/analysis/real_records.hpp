// SPDX-License-Identifier: Apache-2.0
/// Public records of real gyros (MIT licences, not part of this repository), for machines that have them.
#pragma once

#include <optional>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"

namespace gyrotherm::data {

enum class FreeImuAxis { x, y, z };

/// Loads the record with two thermometers, "die" and "barometer", bias in °/h. Returns nothing if GYROTHERM_SHARED is
/// not set in the environment.
[[nodiscard]] std::optional<Dataset> load_freeimu(FreeImuAxis axis);

/// Loads the record over one temperature cycle. Its time stamps cannot be right, so its 420 clusters have 20 rows each
/// and their times are arbitrary. "T" is the temperature of the sensor and "dT" its derivative over clusters (central
/// differences, one-sided at the ends), as in the reference table; bias in °/h. Returns nothing if GYROTHERM_SHARED is
/// not set in the environment. `axis` is 0, 1 or 2.
[[nodiscard]] std::optional<Clusters> load_tofupilot(int axis);

}  // namespace gyrotherm::data
