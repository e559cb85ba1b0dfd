// SPDX-License-Identifier: Apache-2.0
/// Coordinates of the space that samples span about their mean. These coordinates preserve distances. There are fewer
/// of them than inputs if the inputs depend on each other, as the differences of eight thermometers do.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// Returns an orthonormal basis, one vector per column, of the directions in which centred rows differ by at least
/// 1e-13 of the largest extent. Returns the identity if the rows differ in all directions.
[[nodiscard]] Eigen::MatrixXd spanning_directions(const Eigen::Ref<const Eigen::MatrixXd>& centred);

/// Returns the samples, one per row, in coordinates along their spanning_directions(). Returns the samples unchanged if
/// they span all directions.
[[nodiscard]] Eigen::MatrixXd project_to_span(const Eigen::Ref<const SampleMatrix>& x);

}  // namespace gyrotherm::svm
