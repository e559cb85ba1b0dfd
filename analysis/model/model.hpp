/// A trained compensation model: what it takes in, how it computes, and what is known of it. One JSON file.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/methods/function.hpp"
#include "analysis/methods/method.hpp"
#include "analysis/model/reduced_set_summary.hpp"
#include "analysis/model/selection.hpp"
#include "analysis/svm/tuning.hpp"
#include "core/result.hpp"

namespace gyrotherm {

inline constexpr const char* kModelSchema = "gyrotherm-model/2";

struct TrainingRecord {
  std::string run_id;
  std::string path;
  std::string profile_name;
  bool simulated{};
  int clusters{};
  double from_s{}, to_s{};  ///< start of its first cluster and end of its last, since that run started
};

struct Model {
  std::string program_version;
  std::string inputs;             ///< "multi-point", "multi-point-t", "three-point" or the terms as given
  std::string method;             ///< a name of the table of methods
  double cluster_length_s = 100;  ///< of the means it was trained on
  std::vector<Term> terms;
  Scaling scaling;
  double target_mean_deg_per_h{};
  double target_std_deg_per_h{};
  Function function;
  HyperParameters hyper_parameters;  ///< as chosen on the held-out folds
  double effective_parameters{};     ///< of the function; see Fit
  double residual_std_deg_per_h{};   ///< √(RSS/(n − p)) in-sample, p the effective parameters; NaN if p ≥ n
  std::string particulars;           ///< see Fit
  std::optional<ReducedSetSummary> reduction;  ///< of vectors; the figures below are those of the full function
  std::vector<TrainingRecord> trained_on;
  Selection selection;           ///< multi-point only
  TuningSummary tuning;          ///< support vector methods only; else "was not run"
  TuningOptions tuning_options;  ///< as used
  bool quick{};                  ///< tuned with a small swarm, for a try
  std::string folds;             ///< "leave one cycle out (4)", "4 consecutive blocks"
  Figures in_sample;             ///< residual on the training clusters: not a verification
  Figures leave_cycle_out;       ///< each fold predicted by a model refitted without it, selection and scaling included
  std::optional<Figures> nested_leave_cycle_out;  ///< the same, hyper-parameters chosen without the fold too
  Eigen::VectorXd leave_cycle_out_residual;       ///< per training cluster, °/h (kept in the file for the report)
  Eigen::RowVectorXd input_min, input_max;        ///< trained range of each term, unscaled
  std::vector<std::string> warnings;
};

/// Predicted bias of each cluster, °/h. Fails with usage if the clusters lack a thermometer the model needs.
[[nodiscard]] Result<Eigen::VectorXd> predict(const Model& model, const Clusters& clusters);
/// The same from unscaled inputs, rows × terms; NaN where an input is not finite.
[[nodiscard]] Eigen::VectorXd predict(const Model& model, const SampleMatrix& inputs);

[[nodiscard]] std::string to_json(const Model& model);
/// Fails with bad_file: syntax, schema, missing or non-finite numbers, lengths that do not fit; the place is
/// file:line:column for syntax and the JSON path for content.
[[nodiscard]] Result<Model> model_from_json(std::string_view json, const std::string& file);

/// The model file of LIBSVM's svm-predict. Its predictions are f(z), in units of target_std from target_mean.
/// Fails with usage for a model that is not an SVR.
[[nodiscard]] Result<std::string> to_libsvm(const Model& model);
/// The data file of svm-predict: one row "target index:value …" per cluster that has every input, inputs and target
/// scaled as the model scales them. Fails like predict.
[[nodiscard]] Result<std::string> to_libsvm_data(const Model& model, const Clusters& clusters);

}  // namespace gyrotherm
