// SPDX-License-Identifier: Apache-2.0
/// Part of `qualify` for one axis: models, verifications and a report from two runs and optional later ones.
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

/// Run of the experiment with the data of one axis.
struct ExperimentRun {
  std::string stage;  ///< "ramp", "random", "30 days later"
  profile::Profile profile;
  std::uint64_t days_later{};
  data::RecordedRun recorded;
  /// Digest of the record's rows as `export` writes them.
  std::string sha256;
  /// Digest of the record's file; empty if the record is not closed.
  std::string file_sha256{};
};

struct AxisExperiment {
  ExperimentRun rate, random;
  std::vector<ExperimentRun> later;
  std::vector<data::RecordedRun> further;  ///< used to recommend a model
};

/// Extracts one axis of a record. Fails like make_clusters.
[[nodiscard]] Result<data::RecordedRun> extract_axis(const record::Record& record, const std::string& path,
                                                     const data::AxisChoice& of);

/// Returns the digest of a record's rows as `export` writes them.
[[nodiscard]] std::string digest_rows(const record::Record& record);

struct AxisOptions {
  std::string folder;  ///< receives the models and report/
  bool compare{};      ///< trains every other method as well
  model::QualificationOptions training;
  report::ReportedThermal thermal{};
  std::function<void(const std::string& stage)> on_stage{};
};

/// Trained models and the report that was written.
struct AxisOutcome {
  model::Qualification trained;
  report::Report report;
};

/// Trains, verifies, and writes the models and the report. Fails like train() and verify(), or with interrupted or
/// storage.
[[nodiscard]] Result<AxisOutcome> carry_out(AxisExperiment& experiment, const rig::RigFile& rig,
                                            const AxisOptions& options, const ProgressSink& progress,
                                            std::vector<std::string>& warnings);

}  // namespace gyrotherm::app
