// SPDX-License-Identifier: Apache-2.0
/// The parts of the benchmark; each prints tables as Markdown.
#pragma once

#include <string>
#include <vector>

#include "bench/shared/virtual_units.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// Takes each unit in turn as the next one and the others as its type. Prints U and error on its random run over the
/// hours of its own ramp run, with and without the type prior. `inputs` are keywords of --inputs.
[[nodiscard]] Result<void> measure_units(const std::vector<VirtualUnit>& units, const std::string& inputs);

/// Tests whether the residuals of the units' random runs correlate.
[[nodiscard]] Result<void> measure_correlation(const std::vector<VirtualUnit>& units, const std::string& inputs);

/// Measures the gain of learning axes together for synthetic axes with correlated residuals.
[[nodiscard]] Result<void> measure_synthetic();

}  // namespace gyrotherm::bench
