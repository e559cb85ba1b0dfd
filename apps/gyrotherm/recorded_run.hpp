// SPDX-License-Identifier: Apache-2.0
/// Records, as evidence: seen to be as they were written, and ready for analysis.
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record_files.hpp"
#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/model/model.hpp"
#include "analysis/population/type_prior.hpp"
#include "apps/console/command.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// A record whose files were found, and what is known of them; nothing of those that were not verified.
struct CheckedRun {
  record::RecordFiles files;
  record::Verified verified;
};
/// Finds the files of a record and verifies them (verify_record). Fails with bad_file naming the first place that is
/// not as it was written, and like read_record() if the record cannot be read. With `unverified` the files are only
/// found, and a warning is printed.
[[nodiscard]] Result<CheckedRun> check_recorded_run(Console& console, const std::string& path, bool unverified);

struct RecordedRunOptions {
  std::string clusters{};  ///< only these of those that it has: "0:14" for 0 … 13, "14:" for the others; empty: all
  bool unverified = false;
  data::AxisChoice axis{};  ///< empty names: of the only one that it has
  double cluster_length_s = 100;
  bool leaves_out_outliers = false;  ///< load_recorded_runs() alone: samples that data::find_spikes() finds
};
/// Adds --unit and --axis.
void add_axis_options(CLI::App& command, data::AxisChoice& axis);
/// The axis that was asked for or, if none was, the one that the model was trained on.
[[nodiscard]] data::AxisChoice axis_for(const model::Model& model, const data::AxisChoice& asked);
/// Adds the flag --unverified to a command that reads records.
void add_unverified_flag(CLI::App& command, bool& unverified);

/// Fails like check_recorded_run, load_dataset and make_clusters, or with usage if the clusters are no range, or not
/// that many.
[[nodiscard]] Result<data::RecordedRun> load_recorded_run(Console& console, const std::string& path,
                                                          const RecordedRunOptions& options);

/// Several of them, in order.
struct RecordedRuns {
  std::vector<data::Dataset> datasets;
  std::vector<data::Clusters> clusters;
  std::vector<std::string> outliers;  ///< of each record that has any: what was found, and what became of it
};
[[nodiscard]] Result<RecordedRuns> load_recorded_runs(Console& console, const std::vector<std::string>& paths,
                                                      const RecordedRunOptions& options);

/// Where qualify leaves the model of an axis that is called `inputs`: FOLDER/UNIT/AXIS/model-INPUTS.json, without AXIS
/// where the unit has one, without UNIT where the rig file names none.
[[nodiscard]] std::string model_path(const std::string& folder, const data::AxisChoice& axis,
                                     const std::string& inputs);

/// Writes a model, replacing a file of that name. Fails with numeric, and writes nothing, where load_model() would
/// refuse what is to be written; with storage if it cannot be written.
[[nodiscard]] Result<void> write_model(const std::string& path, const model::Model& model);

/// Fails with bad_file.
[[nodiscard]] Result<model::Model> load_model(const std::string& path);
/// Fails with bad_file.
[[nodiscard]] Result<population::TypePrior> load_type_prior(const std::string& path);

}  // namespace gyrotherm::app
