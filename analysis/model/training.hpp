// SPDX-License-Identifier: Apache-2.0
/// Training of a model from clusters, after §3.3 of the paper: correlate, select, scale, tune by a particle swarm on
/// held-out cycles, fit.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/folds.hpp"
#include "analysis/methods/method.hpp"
#include "analysis/model/inputs.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/selection.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

struct TrainingOptions {
  /// Keywords and terms (inputs.hpp); empty: the inputs with which the method was published.
  std::string inputs;
  std::string method = "svr";  ///< table of methods (method.hpp)
  /// Selection rule. If empty, inputs are selected only for multi-point, by |r| > 0.90.
  std::optional<SelectionRule> select;
  data::FoldOptions folds;
  /// Replaces `folds`; each cluster is held out once. No command-line option sets it.
  std::optional<data::FoldPlan> fold_plan;
  bool nested = false;  ///< also Model.nested_leave_cycle_out
  bool quick = false;   ///< 8 particles and 6 iterations
  svm::TuningOptions tuning;
  std::string program_version;
};

/// Trains on the clusters of all datasets together; they must have the same thermometers. The constants of
/// the power-ons, selection and scaling are fitted inside each fold. Clusters without a value of every input are
/// omitted, and a warning states their number. Fails with usage if there is no record, if a run is given twice, if the
/// one-standard-error rule is requested for a method without C, σ and ε, or like the functions below. Fails with
/// numeric if a fit fails, and with interrupted if `progress` requests it.
[[nodiscard]] Result<Model> train(const std::vector<data::Dataset>& datasets,
                                  const std::vector<data::Clusters>& clusters, const TrainingOptions& options,
                                  const ProgressSink& progress = {});

/// Preparation of a fit, for the final model and for every fold: selection, scaling and target units, all learnt only
/// from the training clusters.
struct Preparation {
  std::vector<data::Term> terms;
  Selection selection;
  data::Scaling scaling;
  double target_mean_deg_per_h{};
  double target_std_deg_per_h{};
};

/// Learns a preparation. The folds of the training set are used only by a selection rule that needs held-out folds.
/// Fails with usage if an input or the bias does not vary over the training clusters, or like choose_inputs().
[[nodiscard]] Result<Preparation> prepare(const InputPlan& plan, const data::TrainingSet& training);

/// The clusters of one fold: training part, held-out part and preparation.
struct FoldData {
  /// Training part without the constants of its power-ons, and with the bias filtered by the method, if it has a
  /// filter.
  data::TrainingSet training;
  data::Clusters held_out;
  /// Row indices in the training set before the split.
  std::vector<Eigen::Index> training_rows, held_out_rows;
  Preparation preparation;
};

/// A method with the parameters and options of its fits.
struct EstimatorOptions {
  const methods::Method& method;
  methods::HyperParameters parameters;
  methods::MethodOptions options;
};

/// Splits a training set by its folds. The constants of the power-ons, selection and scaling of each split are learnt
/// only from its training clusters.
/// Fails with interrupted, or like prepare().
[[nodiscard]] Result<std::vector<FoldData>> split_at_folds(const data::TrainingSet& training_set,
                                                           const InputPlan& inputs, const methods::Method& method,
                                                           const ProgressSink& progress);

/// Returns the bias minus the prediction for each of `rows` clusters, °/h, with the constants of the power-ons. A
/// cluster is predicted by a model that was refitted without the cluster's fold; NaN for a cluster that is in no fold.
/// Does not change the estimator's hyper-parameters.
[[nodiscard]] Result<Eigen::VectorXd> leave_out_residual(const std::vector<FoldData>& splits, Eigen::Index rows,
                                                         const EstimatorOptions& estimator,
                                                         const ProgressSink& progress);

/// Returns the residuals of leave_out_residual() with hyper-parameters that are also chosen without the held-out fold:
/// for each fold they are chosen again on folds of its training clusters, including selection and scaling. `splits`
/// belong to the training set. Also fails like ensure_two_folds().
[[nodiscard]] Result<Eigen::VectorXd> nested_residual(const data::TrainingSet& training_set,
                                                      const std::vector<FoldData>& splits, const InputPlan& inputs,
                                                      EstimatorOptions estimator, const ProgressSink& progress);

}  // namespace gyrotherm::model
