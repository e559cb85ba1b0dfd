/// Where a reduced model is made, compressed and checked: coefficients and rates.
#pragma once

#include <vector>

#include "thermal/reduced_basis.hpp"

namespace gyrotherm {

/// Among these the fields are chosen.
[[nodiscard]] std::vector<ThermalPoint> candidate_points(const ReducedModel& about);
/// Over these they are compressed: the same region, finer.
[[nodiscard]] std::vector<ThermalPoint> dense_points(const ReducedModel& about);
/// Off both.
[[nodiscard]] std::vector<ThermalPoint> check_points(const ReducedModel& about);

}  // namespace gyrotherm
