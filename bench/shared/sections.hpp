// SPDX-License-Identifier: Apache-2.0
/// The parts of the benchmark; each prints tables as Markdown.
#pragma once

#include <string>
#include <vector>

#include "bench/shared/virtual_units.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// Treats each unit in turn as the new unit and the others as its type. Prints U and the error on the unit's random run
/// against the number of hours used from its ramp run, with and without the type prior. `inputs` are keywords of
/// --inputs.
[[nodiscard]] Result<void> measure_units(const std::vector<VirtualUnit>& units, const std::string& inputs);

/// Tests whether the residuals of the units' random runs correlate.
[[nodiscard]] Result<void> measure_correlation(const std::vector<VirtualUnit>& units, const std::string& inputs);

/// Measures the gain from learning several axes together, on synthetic axes with correlated residuals.
[[nodiscard]] Result<void> measure_synthetic();

}  // namespace gyrotherm::bench
