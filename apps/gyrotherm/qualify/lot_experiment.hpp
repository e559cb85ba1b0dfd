// SPDX-License-Identifier: Apache-2.0
/// Part of `qualify` for a rig with several axes: trains and reports each axis separately, several in parallel, and
/// summarises the lot.
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "analysis/model/qualification.hpp"
#include "apps/console/console.hpp"
#include "core/result.hpp"
#include "report/lot.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Run with its whole record.
struct LotRun {
  std::string stage, path;
  profile::Profile profile;
  std::uint64_t days_later{};
  record::Record record;
  std::string sha256;  ///< digest of the rows
  std::string file_sha256{};
};

struct LotExperiment {
  std::string out;
  LotRun rate, random;
  std::vector<LotRun> later;
  bool compare = false;                ///< trains every other method as well
  std::vector<data::AxisChoice> only;  ///< empty: all axes
  model::QualificationOptions training;
  report::ReportedThermal thermal{};  ///< all axes have one gyro type
};

/// Returns the axes that the names select in a record: "u1.x" is one axis, "u1" each axis of that unit. Fails with
/// usage and lists the existing axes.
[[nodiscard]] Result<std::vector<data::AxisChoice>> find_axes(const std::vector<std::string>& names,
                                                              const record::RunInfo& info);

/// Trains every axis that has no report on these runs yet and writes the results to OUT/UNIT/AXIS, or to OUT/UNIT if
/// the unit has one axis. Trains as many axes in parallel as there are threads. Writes the report of each unit,
/// OUT/lot.json and OUT/lot.html, unless `only` selects axes. Reports a failed axis in the summary and continues with
/// the others. Shows the progress of all axes on one line. Fails with interrupted or storage.
[[nodiscard]] Result<report::Lot> carry_out(Console& console, const LotExperiment& experiment, const rig::RigFile& rig);

}  // namespace gyrotherm::app
