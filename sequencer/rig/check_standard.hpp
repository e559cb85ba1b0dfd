// SPDX-License-Identifier: Apache-2.0
/// The golden gyro of a rig: [check_standard] in the rig file (docs/check-standard.md).
#pragma once

#include <string>
#include <vector>

#include "core/toml_reader.hpp"

namespace gyrotherm::rig {

struct CheckStandard {
  /// Serial numbers of the golden units: usually one, or one for each axis.
  std::vector<std::string> serial_numbers;
  std::string profile;
  std::string history;             ///< relative to the rig file
  double false_alarm_rate{};       ///< per check run, all charts together
  double mount_change_deg{};       ///< plausible tilt, standard deviation
  double gyro_change_deg_per_h{};  ///< plausible drift; 0: twice the turn-on repeatability
  bool operator==(const CheckStandard&) const = default;
};

/// Reads [check_standard].
[[nodiscard]] CheckStandard read_check_standard(const TomlTable& table);

}  // namespace gyrotherm::rig
