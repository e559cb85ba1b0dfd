// SPDX-License-Identifier: Apache-2.0
/// Coordinates of the space that samples span about their mean. Distances are the same with fewer coordinates if inputs
/// depend on each other, as all differences of eight thermometers do.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// Returns an orthonormal basis, one vector per column, of the directions in which centred rows differ by at least
/// 1e-13 of the largest extent. Returns the identity if these are all directions.
[[nodiscard]] Eigen::MatrixXd spanning_directions(const Eigen::Ref<const Eigen::MatrixXd>& centred);

/// Returns the samples, one per row, in coordinates of these directions. Returns them unchanged if these are all
/// directions.
[[nodiscard]] Eigen::MatrixXd spanned(const Eigen::Ref<const SampleMatrix>& x);

}  // namespace gyrotherm::svm
