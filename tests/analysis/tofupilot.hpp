/// The public record of a real gyro over one temperature cycle (MIT licence, not carried here), where the machine has
/// it. Its time stamps cannot be true, so its clusters are 20 rows each and nothing is claimed of time.
#pragma once

#include <optional>

#include "analysis/data/clusters.hpp"

namespace gyrotherm {

/// 420 clusters; "T" is the sensor's temperature and "dT" its derivative over clusters (central differences, one-sided
/// at the ends), as in the reference table; bias in °/h. Nothing without GYROTHERM_SHARED in the environment.
/// `axis` is 0, 1 or 2.
[[nodiscard]] std::optional<Clusters> load_tofupilot(int axis);

}  // namespace gyrotherm
