// SPDX-License-Identifier: Apache-2.0
/// A fused record against the Earth's rotation, where it is at rest.
#pragma once

#include "analysis/model/fused_axes.hpp"
#include "analysis/model/fused_run.hpp"

namespace gyrotherm::model {

/// Adds to the summary of a run what the Earth's rotation says of it: the error of the rate vector over all clusters
/// (the fixture does not move in a chamber), that of all axes and of three of them alone, and of each axis; and of the
/// last hour of each hold, and of all of these together, rate, heading, biases and turn, and an alarm where χ² of
/// readings and priors is above its limit. Adds nothing if the attitude is not known. A stretch counts the axes that
/// had a part in all of the rate there.
void judge_at_rest(const FusedAxes& axes, const FusionOptions& options, FusedRun& run);

}  // namespace gyrotherm::model
