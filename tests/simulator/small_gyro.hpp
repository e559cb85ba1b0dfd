// SPDX-License-Identifier: Apache-2.0
/// Reduced gyro of nine nodes for tests that do not concern finite elements. A … H are on a ring of Zerodur with a
/// shell around it. Left and right are equal.
#pragma once

#include "simulator/thermal/reduced/reduced_model.hpp"

namespace gyrotherm::simulator {

[[nodiscard]] thermal::ReducedModel small_gyro();

}  // namespace gyrotherm::simulator
