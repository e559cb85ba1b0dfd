// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm report RECORD…`: a calibration report for each unit under test in the records.
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "apps/console/command.hpp"
#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::app {

struct CalibrationArguments {
  std::vector<std::string> runs;
  /// Model files; each applies to the axis on which it was trained.
  std::vector<std::string> left, found;
  /// Folders of models as qualify writes them.
  std::string left_folder, found_folder;
  /// Name of the models in these folders; empty for multi-point-t.
  std::string inputs;
  std::string unit;               ///< empty: each unit of the records
  std::string laboratory, order;  ///< files; if empty, a draft results
  std::vector<std::string> languages{"en"};
  std::string out;
  std::string check_standard;  ///< history of check runs; empty: that of the rig of each record, if it has one
  bool unverified = false;
};

/// Adds the options --laboratory and --order.
void add_report_texts(CLI::App& command, CalibrationArguments& options);
/// Checks the laboratory file and the order before a command that runs for days and writes its report at the end.
/// `from` names the source of `units`. Fails with bad_file, also if the order names another unit.
[[nodiscard]] Result<void> check_report_texts(const CalibrationArguments& options,
                                              const std::vector<record::UnitInfo>& units, const std::string& from);

/// Writes calibration.json and its views into OUT, or into OUT/UNIT if the records have several units and none was
/// named. Prints the missing information that makes the report a draft. Fails with usage, bad_file or storage.
[[nodiscard]] Result<Exit> calibrate(Console& console, const CalibrationArguments& options);

/// Makes the report of one unit again, without writing it, to compare it with a draft. `unit` is its name in the rig.
/// Fails like calibrate().
[[nodiscard]] Result<report::CalibrationReport> make_calibration(Console& console, const CalibrationArguments& options,
                                                                 const std::string& unit);

}  // namespace gyrotherm::app
