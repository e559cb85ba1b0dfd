// SPDX-License-Identifier: Apache-2.0
/// The paper's §3.3 from clusters to a model: correlate, select, scale, tune by swarm on held-out cycles, fit.
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
  std::string inputs;                   ///< words and terms (inputs.hpp); empty: what the method is published with
  std::string method = "svr";           ///< a name of the table of methods (method.hpp)
  std::optional<SelectionRule> select;  ///< nothing: only multi-point selects, by |r| > 0.90
  data::FoldOptions folds;
  std::optional<data::FoldPlan>
      fold_plan;              ///< instead of `folds`, each cluster held out once: what users are not offered
  bool nested = false;        ///< also Model.nested_leave_cycle_out
  bool quick = false;         ///< a swarm of 8 particles and 6 iterations
  svm::TuningOptions tuning;  ///< its choice is for the support vector methods alone
  std::string program_version;
};

/// Trains on the clusters of all datasets together (they must have the same thermometers). Selection and scaling are
/// fitted inside each fold. Clusters without a value of every input are left out, and a warning says how many. Fails
/// with usage (no record, a run given twice, the one-standard-error rule of a method without C, σ and ε, or as the
/// parts below do), with numeric, or with interrupted once `progress` says so.
[[nodiscard]] Result<Model> train(const std::vector<data::Dataset>& datasets,
                                  const std::vector<data::Clusters>& clusters, const TrainingOptions& options,
                                  const ProgressSink& progress = {});

/// What the final model and every fold have in common before the fit: selection, scaling and target units, all learnt
/// from the training clusters alone.
struct Preparation {
  std::vector<data::Term> terms;
  Selection selection;
  data::Scaling scaling;
  double target_mean_deg_per_h{};
  double target_std_deg_per_h{};
};

/// Learns a preparation. The folds of the training set are for a selection that holds out; nothing else asks them.
/// Fails with usage if an input or the bias does not vary over the training clusters, or as choose_inputs does.
[[nodiscard]] Result<Preparation> prepare(const InputPlan& plan, const data::TrainingSet& training);

/// The clusters of one fold: what is learnt from, what is held out, and what was learnt before the fit.
struct FoldData {
  data::TrainingSet training;  ///< as the method learns from it: its filter has smoothed the bias, if it has one
  data::Clusters held_out;
  std::vector<Eigen::Index> training_rows, held_out_rows;  ///< of the training set that was split
  Preparation preparation;
};

/// A method with all that its fits need.
struct EstimatorOptions {
  const methods::Method& method;
  methods::HyperParameters parameters;
  methods::MethodOptions options;
};

/// Splits a training set at its folds; selection and scaling of each are learnt from its training clusters alone.
/// Fails with interrupted, or as prepare does.
[[nodiscard]] Result<std::vector<FoldData>> split_at_folds(const data::TrainingSet& training_set,
                                                           const InputPlan& inputs, const methods::Method& method,
                                                           const ProgressSink& progress);

/// Bias less prediction of each of `rows` clusters, °/h, by a model refitted without its fold; NaN where a cluster is
/// in none. The estimator's hyper-parameters are taken as they are.
[[nodiscard]] Result<Eigen::VectorXd> leave_out_residual(const std::vector<FoldData>& splits, Eigen::Index rows,
                                                         const EstimatorOptions& estimator,
                                                         const ProgressSink& progress);

/// The residuals of leave_out_residual with hyper-parameters that have not seen the held-out fold either: for each fold
/// they are chosen anew by the folds that remain among its training clusters, selection and scaling inside. `splits`
/// are those of the training set. Fails like with_two_folds too.
[[nodiscard]] Result<Eigen::VectorXd> nested_residual(const data::TrainingSet& training_set,
                                                      const std::vector<FoldData>& splits, const InputPlan& inputs,
                                                      EstimatorOptions estimator, const ProgressSink& progress);

}  // namespace gyrotherm::model
