// SPDX-License-Identifier: Apache-2.0
/// The bounded point of inputs beyond the trained range as C (Outside::continued).
#pragma once

#include <string>

#include "analysis/model/model.hpp"

namespace gyrotherm::model {

/// Writes "static void bound(double x[])", which moves inputs to the bounded point; nothing for a function that is all
/// plane.
[[nodiscard]] std::string bounding_in_c(const Model& model);

}  // namespace gyrotherm::model
