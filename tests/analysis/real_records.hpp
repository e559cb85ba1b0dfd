// SPDX-License-Identifier: Apache-2.0
/// Public records of real gyros (MIT licences, not carried here), where the machine has them.
#pragma once

#include <optional>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"

namespace gyrotherm::data {

enum class FreeImuAxis { x, y, z };

/// The record with two thermometers, "die" and "barometer", bias in °/h; nothing without GYROTHERM_SHARED in the
/// environment.
[[nodiscard]] std::optional<Dataset> load_freeimu(FreeImuAxis axis);

/// The record over one temperature cycle. Its time stamps cannot be true, so its clusters are 20 rows each and nothing
/// is claimed of time: 420 clusters; "T" is the sensor's temperature and "dT" its derivative over clusters (central
/// differences, one-sided at the ends), as in the reference table; bias in °/h. Nothing without GYROTHERM_SHARED in the
/// environment. `axis` is 0, 1 or 2.
[[nodiscard]] std::optional<Clusters> load_tofupilot(int axis);

}  // namespace gyrotherm::data
