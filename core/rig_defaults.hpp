// SPDX-License-Identifier: Apache-2.0
/// Defaults of keys of rig files that the run's program, the guard and the live page share.
#pragma once

#include <chrono>

#include "core/quantity.hpp"

namespace gyrotherm {

/// Default of [safe] observe.
inline constexpr Duration kUsualObserve = std::chrono::minutes(5);

}  // namespace gyrotherm
