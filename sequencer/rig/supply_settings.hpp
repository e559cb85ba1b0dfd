// SPDX-License-Identifier: Apache-2.0
/// Power supplies of a rig file, [[supply]]: the instruments, their outputs, and the units under test that they feed.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/supply/power_supply.hpp"
#include "drivers/wires.hpp"
#include "sequencer/rig/gyro_settings.hpp"

namespace gyrotherm::rig {

/// Limits of a measured quantity; absent: no limit.
struct PowerLimits {
  std::optional<double> lowest, highest;
};

/// One used output.
struct SupplyOutput {
  drivers::OutputSettings settings;
  /// First part of the names of its values: "supply" in "supply_voltage_v".
  std::string name;
  /// A unit that the output feeds, and the indices of voltage and current among the values of the unit that other
  /// instruments measure.
  struct Share {
    std::size_t unit{};
    std::size_t voltage{};
    std::size_t current{};
  };
  std::vector<Share> shares{};
  /// Limits while the output is on.
  PowerLimits voltage{}, current{};
};

struct SupplySettings {
  std::string line;
  /// The description, with the link for the line selected.
  drivers::SupplyDescription description;
  std::vector<SupplyOutput> outputs;
  /// The outputs are switched off when the run is aborted or stopped and the chamber is made safe.
  bool is_off_on_stop{};
  /// Time after switching on in which the silence of a unit is no fault.
  Duration boot{};
};

/// Returns the instrument's title, such as "supply 1".
[[nodiscard]] std::string supply_title(std::size_t index);
/// Returns the title of one of its outputs, such as "supply 1, output 2".
[[nodiscard]] std::string output_title(std::size_t supply, const SupplyOutput& output);

/// Reads every [[supply]]: `line`, `description` (a path relative to `rig_file`, or the name of a shipped file),
/// `on_stop`, `boot`, and each [[supply.output]]: `output` (from 1), `name`, `gyros` (the units that it feeds; optional
/// if the rig has only one), `voltage_v`, `current_a`, `over_voltage_v`, `over_current_a`, and the limits
/// `lowest_v`, `highest_v`, `lowest_a`, `highest_a`. Appends voltage and current of each output to the values of its
/// units. `known` contains the texts of the descriptions, in order, if they are known already. Fails with bad_file if a
/// description cannot be used. Records errors of the rig file in its tables.
[[nodiscard]] Result<std::vector<SupplySettings>> read_supplies(const TomlTable& root, const std::string& rig_file,
                                                                std::vector<UnitSettings>& units,
                                                                const std::vector<std::string>& known);

/// Returns the names of the units that no supply feeds; empty if there is no supply or every unit is fed.
[[nodiscard]] std::vector<std::string> list_unfed_units(const std::vector<SupplySettings>& supplies,
                                                        const std::vector<UnitSettings>& units);

/// Describes a supply as the rig file states it, for people.
[[nodiscard]] std::string describe(const SupplySettings& supply, const std::vector<UnitSettings>& units);

/// Makes the driver of a real supply on its line. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<drivers::PowerSupply> make_supply(const SupplySettings& settings,
                                                                const std::string& place, const drivers::Line& line);
/// Makes the driver on the wire of a virtual supply, which needs no pauses.
[[nodiscard]] std::unique_ptr<drivers::PowerSupply> make_supply(const SupplySettings& settings,
                                                                const std::string& place,
                                                                std::unique_ptr<drivers::ByteStream> stream,
                                                                const Clock* clock);

}  // namespace gyrotherm::rig
