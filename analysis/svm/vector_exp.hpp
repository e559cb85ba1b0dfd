/// exp of whole arrays, several times faster than one call per element.
#pragma once

#include <Eigen/Core>

namespace gyrotherm {

/// out_i = exp(scale · v_i) to a relative error below 4e-16, for `count` values with scale · v_i ≤ 0; 0 where that is
/// below −708. exp(0) is exactly 1. `out` may be `values`.
void exponentiate(const double* values, Eigen::Index count, double scale, double* out);

}  // namespace gyrotherm
