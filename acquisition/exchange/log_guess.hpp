// SPDX-License-Identifier: Apache-2.0
/// Which messages of an autopilot's log a map should read.
#pragma once

#include <string>
#include <vector>

#include "acquisition/exchange/log_reading.hpp"

namespace gyrotherm::exchange {

/// A gyro of a log, with the temperature of its own.
struct LoggedGyro {
  std::string name{};               ///< "imu", "imu1"
  std::vector<std::string> axes{};  ///< columns: x, y, z as far as there are
  std::string temperature{};        ///< a column; empty: there is none
};

struct LogGuess {
  std::vector<LoggedGyro> gyros{};
  std::vector<std::string> others{};  ///< columns of temperatures that belong to no gyro
};

/// Of the columns that were published: every instance of `sensor_gyro`, else of `sensor_combined`; of ArduPilot each
/// `IMU`, else `GYR`; else the first message with names of a gyro. Never what a filter estimates, an integral, the time
/// or the count of one. Other temperatures are those of barometers, which are near the gyro.
[[nodiscard]] LogGuess guess_log(const std::vector<LogColumn>& published);

}  // namespace gyrotherm::exchange
