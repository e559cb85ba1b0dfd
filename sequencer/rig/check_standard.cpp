// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/check_standard.hpp"

#include <fmt/format.h>

#include <set>

#include "acquisition/record/check_history.hpp"
#include "core/serial_number.hpp"

namespace gyrotherm::rig {

CheckStandard read_check_standard(const TomlTable& table) {
  constexpr double kLowestRate = 1e-4, kHighestRate = 0.2;
  CheckStandard standard{.serial_numbers = table.texts("serial_numbers"),
                         .profile = table.text("profile", "check-standard"),
                         .history = table.text("history", record::kDefaultCheckHistory),
                         .false_alarm_rate = table.number("false_alarm_rate", 0.01),
                         .mount_change_deg = table.number("mount_change_deg", 0.1),
                         .gyro_change_deg_per_h = table.number("gyro_change_deg_per_h", 0)};
  if (standard.serial_numbers.empty())
    table.note_error("serial_numbers", "expected the serial number of at least one golden gyro");
  std::set<std::string> seen;
  for (std::string& serial : standard.serial_numbers) {
    auto number = parse_serial_number(serial);
    if (!number) table.note_error("serial_numbers", number.error().what);
    if (number) serial = *number;
    if (!seen.insert(serial).second) table.note_error("serial_numbers", fmt::format("\"{}\" is listed twice", serial));
  }
  if (standard.profile.empty()) table.note_error("profile", "expected the name or the path of a profile");
  if (standard.history.empty()) table.note_error("history", "expected the path of a file");
  if (!(standard.false_alarm_rate >= kLowestRate && standard.false_alarm_rate <= kHighestRate))
    table.note_error("false_alarm_rate", "expected 0.0001 to 0.2");
  if (!(standard.mount_change_deg > 0)) table.note_error("mount_change_deg", "expected a number above 0");
  if (!(standard.gyro_change_deg_per_h >= 0)) table.note_error("gyro_change_deg_per_h", "expected 0 or more");
  return standard;
}

}  // namespace gyrotherm::rig
