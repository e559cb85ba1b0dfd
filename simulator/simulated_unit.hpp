// SPDX-License-Identifier: Apache-2.0
/// What a virtual chamber needs to know beside the items of its register map: the map's [simulated] table.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::simulator {

/// What switches the unit on, and what it shows then.
struct SimulatedUnit {
  struct Shows {
    std::string item;
    std::map<std::string, double>
        values;  ///< by state: "off", "on", "running" (or "ramping", "soaking"), "held", "done"
  };
  std::vector<drivers::Condition> turns_on, turns_off;  ///< by writing this
  std::vector<drivers::Condition> starts_program, holds_program, resumes_program, ends_program;
  std::vector<drivers::Condition> creates_program;  ///< by writing this the memory is emptied
  std::vector<drivers::Condition> stores_program,
      loads_program;                         ///< by writing this the edit window is kept, or comes back
  std::string program_number, program_step;  ///< items that say which program and step is started
  std::vector<Shows> shows;
  std::vector<std::pair<std::string, double>> initial;
  std::vector<std::pair<std::string, std::string>> initial_texts;
  bool silent_exceptions{};           ///< no reply where others answer with an exception
  bool ignores_blocks_elsewhere{};    ///< function 16 outside the profile memory is acknowledged and does nothing
  std::vector<std::string> when_off;  ///< items that hold their first sentinel while the unit is off
};

/// Reads the table from the map's text, which `file` names in faults. Fails with bad_file if it has mistakes.
[[nodiscard]] Result<SimulatedUnit> read_simulated_unit(const drivers::RegisterMap& map, const std::string& file);

}  // namespace gyrotherm::simulator
