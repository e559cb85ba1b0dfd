// SPDX-License-Identifier: Apache-2.0
/// Finds, verifies and loads records as input of an analysis.
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

/// Files of a record and the result of their verification; empty if not verified.
struct CheckedRun {
  record::RecordFiles files;
  record::Verified verified;
};
/// Prints a warning if files of an unfinished record are missing (record::missing_files).
void warn_of_missing_files(Console& console, const record::RecordFiles& files);
/// Finds the files of a record and verifies them (verify_record). Fails with bad_file, which names the first altered
/// position, or like read_record() if the record cannot be read. With `unverified`, only finds the files and prints a
/// warning.
[[nodiscard]] Result<CheckedRun> check_recorded_run(Console& console, const std::string& path, bool unverified);

struct RecordedRunOptions {
  /// Range of clusters: "0:14" for 0 … 13, "14:" for 14 and later, empty for all.
  std::string clusters{};
  bool unverified = false;
  /// Chosen axis. Empty if the record has only one axis.
  data::AxisChoice axis{};
  double cluster_length_s = 100;
  /// Removes the samples that data::find_spikes() finds. Only for load_recorded_runs().
  bool leaves_out_outliers = false;
};
/// Adds --unit and --axis.
void add_axis_options(CLI::App& command, data::AxisChoice& axis);
/// Returns the requested axis or, if none was requested, the one on which the model was trained.
[[nodiscard]] data::AxisChoice axis_for(const model::Model& model, const data::AxisChoice& requested);
/// Adds the flag --unverified to a command that reads records.
void add_unverified_flag(CLI::App& command, bool& unverified);

/// Verifies and loads a record and makes its clusters. Fails like check_recorded_run, load_dataset and make_clusters,
/// or with usage if the range of clusters is malformed or exceeds the record.
[[nodiscard]] Result<data::RecordedRun> load_recorded_run(Console& console, const std::string& path,
                                                          const RecordedRunOptions& options);

/// Repeats the warnings of the import of a record, and describes what its clusters leave out. Each text begins with the
/// path. Returns nothing for a record that was not imported.
[[nodiscard]] std::vector<std::string> import_warnings(const data::Dataset& dataset, const data::Clusters& clusters);

/// Several loaded records, in order.
struct RecordedRuns {
  std::vector<data::Dataset> datasets;
  std::vector<data::Clusters> clusters;
  std::vector<std::string> outliers;  ///< per affected record: findings and treatment
};
[[nodiscard]] Result<RecordedRuns> load_recorded_runs(Console& console, const std::vector<std::string>& paths,
                                                      const RecordedRunOptions& options);

/// Returns the path where qualify writes the model `inputs` of an axis: FOLDER/UNIT/AXIS/model-INPUTS.json. AXIS is
/// omitted if the unit has a single axis, UNIT if the rig file does not name it.
[[nodiscard]] std::string model_path(const std::string& folder, const data::AxisChoice& axis,
                                     const std::string& inputs);

/// Writes a model and replaces an existing file. Fails with numeric, and writes nothing, if load_model() would refuse
/// the result; fails with storage if the file cannot be written.
[[nodiscard]] Result<void> write_model(const std::string& path, const model::Model& model);

/// Reads a model. Fails with bad_file.
[[nodiscard]] Result<model::Model> load_model(const std::string& path);
/// Reads a type prior. Fails with bad_file.
[[nodiscard]] Result<population::TypePrior> load_type_prior(const std::string& path);

}  // namespace gyrotherm::app
