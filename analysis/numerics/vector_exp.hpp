/// exp of whole arrays, several times faster than one call per element.
#pragma once

#include <Eigen/Core>

namespace gyrotherm {

/// Replaces each of `count` values v by exp(scale · v) to a relative error below 4e-16, where scale · v ≤ 0; by 0 where that
/// is below −708. exp(0) is exactly 1.
void exponentiate(double* values, Eigen::Index count, double scale);

}  // namespace gyrotherm
