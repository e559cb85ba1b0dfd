// SPDX-License-Identifier: Apache-2.0
/// Identification of the units at the start of a run: a serial number for each position that the rig file leaves open.
/// The position of a unit is the unit's name in the rig file. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::rig {

/// The serial number of the unit at a position.
struct UnitSerial {
  std::string unit{};
  /// Empty: the position is empty.
  std::string serial_number{};
  bool operator==(const UnitSerial&) const = default;
};

/// Parses "u1=0042", or "u1=" for an empty position. On a rig with one unit, "0042" is sufficient; a number
/// that contains "=" must follow the name of the unit. Fails with usage, naming the nearest unit, if the rig has no
/// unit of that name, and if the serial number is invalid.
[[nodiscard]] Result<UnitSerial> parse_unit_serial(std::string_view text, const RigFile& rig);

/// Sets the serial number of a unit, or marks its position as empty. Fails with usage, naming both values, if the rig
/// file or an earlier call gives another serial number; if the serial number is that of another unit; or if no position
/// would remain in use.
[[nodiscard]] Result<void> identify_unit(RigFile& rig, const UnitSerial& serial);

/// Fails with usage if two units of the rig have the same serial number.
[[nodiscard]] Result<void> check_serials_differ(const RigFile& rig);

/// Returns the names of the units that are in use and have no serial number.
[[nodiscard]] std::vector<std::string> find_unidentified(const RigFile& rig);

/// Returns the units of the rig whose positions are in use.
[[nodiscard]] std::vector<record::UnitInfo> list_units_in_use(const RigFile& rig);

/// Describes the units and the order: "u1 0042, u2 0043; u3 not used; order 2026-17".
[[nodiscard]] std::string describe_identification(const RigFile& rig);

/// Restores the identification of a recorded run.
void restore_identification(RigFile& rig, const record::RunInfo& info);

/// Compares a serial number with that of the recorded run. Fails with usage, naming both values, if they differ.
[[nodiscard]] Result<void> compare_with_record(const UnitSerial& serial, const record::RunInfo& info,
                                               const std::string& path);

}  // namespace gyrotherm::rig
