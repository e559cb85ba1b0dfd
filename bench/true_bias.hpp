// SPDX-License-Identifier: Apache-2.0
/// The truth that benchmarks judge by.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/result.hpp"

namespace gyrotherm::record {
struct Record;
}

namespace gyrotherm::bench {

/// The true bias in each recorded second of a run on a virtual rig, °/h, turn-on and wander included: all but the angle
/// random walk. The virtual laboratory lives through the recorded set points once more. Fails with numeric if the
/// pulses that come out are not the record's.
[[nodiscard]] Result<Eigen::VectorXd> true_bias(const record::Record& record, const std::string& path);

}  // namespace gyrotherm::bench
