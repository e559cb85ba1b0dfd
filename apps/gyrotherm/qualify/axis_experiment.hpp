// SPDX-License-Identifier: Apache-2.0
/// What `qualify` makes of one axis: models, verifications and a report, of two runs and perhaps later ones.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/record.hpp"
#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/model/qualification.hpp"
#include "core/result.hpp"
#include "report/report.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// One run of the experiment as one axis saw it.
struct ExperimentRun {
  std::string stage;  ///< "rate", "random", "30 days later"
  profile::Profile profile;
  std::uint64_t days_later{};
  data::RecordedRun recorded;
  std::string sha256;  ///< of the record's rows as `export` writes them
};

struct AxisExperiment {
  ExperimentRun rate, random;
  std::vector<ExperimentRun> later;
  std::vector<data::RecordedRun> further;  ///< on which a model is recommended
};

/// Of one axis of a record. Fails like make_clusters.
[[nodiscard]] Result<data::RecordedRun> recorded_run_of(const record::Record& record, const std::string& path,
                                                        const data::AxisChoice& of);

/// The digest of a record's rows as `export` writes them.
[[nodiscard]] std::string digest_of(const record::Record& record);

struct AxisOptions {
  std::string folder;   ///< for its models, and for report/ in it
  bool compare = true;  ///< every other method beside the three models
  model::QualificationOptions training;
  report::ReportedThermal thermal{};                       ///< the gyro's thermal model
  std::function<void(const std::string& stage)> begins{};  ///< a stage, for timings
};

/// What was trained, and the report of it, which has been written.
struct AxisOutcome {
  model::Qualification trained;
  report::Report report;
};

/// Trains, verifies, writes the models and the report. Fails like train() and verify(), with interrupted or storage.
[[nodiscard]] Result<AxisOutcome> carry_out(AxisExperiment& experiment, const rig::RigFile& rig,
                                            const AxisOptions& options, const ProgressSink& progress,
                                            std::vector<std::string>& warnings);

}  // namespace gyrotherm::app
