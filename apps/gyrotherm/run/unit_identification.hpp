// SPDX-License-Identifier: Apache-2.0
/// Identification of the units when a run starts: the serial numbers from the options, the order and the prompts, and
/// their comparison with the order.
#pragma once

#include <string>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/console/console.hpp"
#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

struct IdentificationOptions {
  std::vector<std::string> units;  ///< "u1=0042"
  std::string order;               ///< file; may be empty
  bool again = false;              ///< permits another run of a unit
  bool wait = false;               ///< asks on the live page
};

/// Adds the option --unit.
void add_unit_option(CLI::App& command, std::vector<std::string>& units);
/// Adds the options --unit, --wait-for-units and --again. The command itself adds --order.
void add_identification_options(CLI::App& command, IdentificationOptions& options);

/// The run that is about to start.
struct PlannedRun {
  std::string record;   ///< path
  std::string profile;  ///< name
  std::string folder;   ///< where earlier runs are searched for
};

/// Sets the serial numbers of the units: from the options, from the units that the order names by position, and from
/// prompts on the terminal or on the live page. A virtual rig needs no serial numbers. Call it before signals are
/// handled, because a prompt on a terminal waits for input. Fails with usage if a number is missing and no person can
/// be asked, or if a number is given twice or contradicts the rig file; with bad_file if the order is invalid or does
/// not contain a unit; with refused if a unit has already finished a run of this profile in this order, unless `again`
/// is set or the operator confirms it.
[[nodiscard]] Result<void> identify_units(Console& console, rig::RigFile& rig, const IdentificationOptions& options,
                                          const PlannedRun& run);

/// Takes over the units of an existing record, and compares them with the values of --unit and with the rig file. Asks
/// nothing. Fails with usage if they differ, or as record::read_info() does.
[[nodiscard]] Result<void> keep_units_of_record(rig::RigFile& rig, const std::vector<std::string>& units,
                                                const std::string& record);

}  // namespace gyrotherm::app
