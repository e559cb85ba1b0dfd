// SPDX-License-Identifier: Apache-2.0
/// The parts of the benchmark, each of which prints tables as Markdown.
#pragma once

#include <string>
#include <vector>

#include "bench/shared/virtual_units.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// Each unit in turn is the next one, and the others are its type: U and error on its random run against hours of its
/// own rate run, with and without the type prior. `inputs` are words of --inputs.
[[nodiscard]] Result<void> measure_units(const std::vector<VirtualUnit>& units, const std::string& inputs);

/// Whether what models leave of the units' random runs correlates at all.
[[nodiscard]] Result<void> measure_correlation(const std::vector<VirtualUnit>& units, const std::string& inputs);

/// What learning axes together gains where their unexplained parts do correlate, by design.
[[nodiscard]] Result<void> measure_synthetic();

}  // namespace gyrotherm::bench
