// SPDX-License-Identifier: Apache-2.0
/// Calibration reports as unlike each other as they can be.
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

/// A report of random size, of which much is not known, with texts of any characters.
[[nodiscard]] CalibrationReport random_calibration(std::uint64_t seed);

}  // namespace gyrotherm::report
