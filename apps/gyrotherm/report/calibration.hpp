// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm report RECORD…`: a calibration report of each unit under test of some records.
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "apps/console/command.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

struct CalibrationArguments {
  std::vector<std::string> runs;
  std::vector<std::string> left, found;   ///< files of models, each for the axis that it was trained on
  std::string left_folder, found_folder;  ///< … or folders as qualify leaves them
  std::string inputs;                     ///< name of the models in these; empty: multi-point-t
  std::string unit;                       ///< empty: each unit of the records
  std::string laboratory, order;          ///< files; empty: a draft
  std::vector<std::string> languages{"en"};
  std::string out;
  bool unverified = false;
};

/// The options --laboratory and --order.
void add_report_texts(CLI::App& command, CalibrationArguments& options);
/// Reads these files alone, for commands that work for days before they write a report of these units, as `from` has
/// them. Fails with bad_file, also if the order speaks of another unit.
[[nodiscard]] Result<void> check_report_texts(const CalibrationArguments& options,
                                              const std::vector<record::UnitInfo>& units, const std::string& from);

/// Writes calibration.json and its views into OUT, or into OUT/UNIT where the records have several units and none was
/// named; says what makes it a draft. Fails with usage, bad_file or storage.
[[nodiscard]] Result<Exit> calibrate(Console& console, const CalibrationArguments& options);

}  // namespace gyrotherm::app
