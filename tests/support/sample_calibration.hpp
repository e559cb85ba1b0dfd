// SPDX-License-Identifier: Apache-2.0
/// Calibration report with invented values. It has two axes, all groups of results, both languages and every optional
/// part.
#pragma once

#include "report/calibration.hpp"

namespace gyrotherm::report {

[[nodiscard]] CalibrationReport sample_calibration();

}  // namespace gyrotherm::report
