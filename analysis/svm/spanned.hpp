// SPDX-License-Identifier: Apache-2.0
/// The space that samples span about their mean: the same distances from fewer numbers where inputs depend on each
/// other, as all differences of eight thermometers do.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// An orthonormal basis, a column each, of the directions in which rows about their mean differ: those in which they
/// reach at least 1e-13 of their greatest reach. The identity where these are all.
[[nodiscard]] Eigen::MatrixXd directions_of(const Eigen::Ref<const Eigen::MatrixXd>& centred);

/// The samples, a row each, in coordinates of these directions; as they are where these are all.
[[nodiscard]] Eigen::MatrixXd spanned(const Eigen::Ref<const SampleMatrix>& x);

}  // namespace gyrotherm::svm
