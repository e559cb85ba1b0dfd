// SPDX-License-Identifier: Apache-2.0
/// Loads public records of real gyros. They have MIT licences and are not part of this repository. Tests skip them if
/// the machine does not have them.
#pragma once

#include <optional>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"

namespace gyrotherm::data {

enum class FreeImuAxis { x, y, z };

/// Loads the record with two thermometers, "die" and "barometer", bias in °/h. Returns nothing if GYROTHERM_SHARED is
/// not set in the environment.
[[nodiscard]] std::optional<Dataset> load_freeimu(FreeImuAxis axis);

/// Loads the record over one temperature cycle for axis 0, 1 or 2, with the bias in °/h. The time stamps of the record
/// are implausible, so its 420 clusters have 20 rows each and arbitrary times. As in the reference table, "T" is the
/// temperature of the sensor and "dT" its derivative over clusters (central differences, one-sided at the ends).
/// Returns nothing if GYROTHERM_SHARED is not set in the environment.
[[nodiscard]] std::optional<Clusters> load_tofupilot(int axis);

}  // namespace gyrotherm::data
