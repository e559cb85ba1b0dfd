// SPDX-License-Identifier: Apache-2.0
/// What of a record others want to see, in units of their world.
#pragma once

#include <cstddef>
#include <vector>

#include "acquisition/record/record.hpp"

namespace gyrotherm::exchange {

/// The temperatures of a thermometer in °C, by its calibration; NaN where there was no reading.
[[nodiscard]] std::vector<double> temperatures_of(const record::Record& record, std::size_t thermometer);

/// The rate about an axis in °/h, the Earth's with it; NaN where there is none.
[[nodiscard]] std::vector<double> rates_of(const record::Record& record, std::size_t unit, std::size_t axis);

}  // namespace gyrotherm::exchange
