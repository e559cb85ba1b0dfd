// SPDX-License-Identifier: Apache-2.0
/// Calibration reports that differ from each other as much as possible.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "report/calibration.hpp"
#include "report/dcc.hpp"

namespace gyrotherm::report {

struct VariedReport {
  std::string name;
  CalibrationReport report;
  DccOptions options{};
};

[[nodiscard]] std::vector<VariedReport> varied_calibrations();

/// Returns a report of random size with many unknown values and arbitrary characters in its texts.
[[nodiscard]] CalibrationReport random_calibration(std::uint64_t seed);

}  // namespace gyrotherm::report
