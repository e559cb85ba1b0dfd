// SPDX-License-Identifier: Apache-2.0
/// True bias as a reference for benchmarks.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/result.hpp"

namespace gyrotherm::record {
struct Record;
}

namespace gyrotherm::bench {

/// Returns the true bias in each recorded second of a run on a virtual rig, °/h: everything except the angle random
/// walk, including turn-on and wander. Simulates the recorded set points again. Fails with numeric if the resulting
/// pulses differ from those in the record.
[[nodiscard]] Result<Eigen::VectorXd> true_bias(const record::Record& record, const std::string& path);

}  // namespace gyrotherm::bench
