// SPDX-License-Identifier: Apache-2.0
/// What `qualify` makes of a rig with many axes: each trained and reported by itself, side by side, and a summary of
/// the lot.
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

/// One run, with all that it recorded.
struct LotRun {
  std::string stage, path;
  profile::Profile profile;
  std::uint64_t days_later{};
  record::Record record;
  std::string sha256;
};

struct LotExperiment {
  std::string out;
  LotRun rate, random;
  std::vector<LotRun> later;
  bool compare = false;                ///< every other method beside the three models, for each axis
  std::vector<data::AxisChoice> only;  ///< these axes of all; empty: every one
  model::QualificationOptions training;
  report::ReportedThermal thermal{};  ///< all axes have one type of gyro
};

/// "u1.x" and "u1" (each axis of that unit) as the axes that a record has. Fails with usage, naming those that are
/// there.
[[nodiscard]] Result<std::vector<data::AxisChoice>> axes_called(const std::vector<std::string>& names,
                                                                const record::RunInfo& info);

/// Trains every axis that has no report of these very runs yet, as many side by side as there are threads, into
/// OUT/UNIT/AXIS (OUT/UNIT where a unit has one axis); writes the report of each unit, OUT/lot.json and OUT/lot.html,
/// unless only some axes are wanted. What of it fails for one axis is told in the summary and stops no other. One line
/// shows how far all of it is. Fails with interrupted or storage.
[[nodiscard]] Result<report::Lot> carry_out(Console& console, const LotExperiment& experiment, const rig::RigFile& rig);

}  // namespace gyrotherm::app
