// SPDX-License-Identifier: Apache-2.0
/// A calibration report of invented numbers: two axes, all groups of results, both languages, everything that may be
/// there.
#pragma once

#include "report/calibration.hpp"

namespace gyrotherm::report {

[[nodiscard]] CalibrationReport sample_calibration();

}  // namespace gyrotherm::report
