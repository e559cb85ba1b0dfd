/// A lesson split at its folds, and what a method does on what is held out.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/data/folds.hpp"
#include "analysis/methods/method.hpp"
#include "analysis/model/fitting.hpp"
#include "analysis/model/inputs.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Clusters of one fold: what is learnt from, what is held out, and what was learnt before the fit.
struct FoldData {
  TrainingSet training;  ///< as the method learns from it: its filter has smoothed the bias, if it has one
  Clusters held_out;
  std::vector<Eigen::Index> held_out_rows;  ///< of the lesson that was split
  Preparation preparation;
};

/// A method with all that its fits need.
struct EstimatorOptions {
  const Method& method;
  HyperParameters parameters;
  MethodOptions options;
};

/// Bias of the clusters as the method learns from it.
[[nodiscard]] Clusters as_learnt_by(const Method& method, Clusters training);

/// One split per fold; selection and scaling are learnt from its training clusters alone. Fails with interrupted, or as
/// prepare does.
[[nodiscard]] Result<std::vector<FoldData>> split_at_folds(const TrainingSet& training_set, const InputPlan& inputs,
                                                           const Method& method, const ProgressSink& progress);

/// The method's hyper-parameters by these splits alone.
[[nodiscard]] Result<Choice> choose(const std::vector<FoldData>& splits, const EstimatorOptions& estimator,
                                    const ProgressSink& progress);

[[nodiscard]] Result<Model> fit(const Preparation& preparation, const Clusters& training,
                                const EstimatorOptions& estimator);

/// Bias less prediction of each of `rows` clusters, °/h, by a model refitted without its fold; NaN where a cluster is
/// in none. The recipe's hyper-parameters are taken as they are.
[[nodiscard]] Result<Eigen::VectorXd> leave_out_residual(const std::vector<FoldData>& splits, Eigen::Index rows,
                                                         const EstimatorOptions& estimator,
                                                         const ProgressSink& progress);

/// The same with hyper-parameters that have not seen the held-out fold either: for each they are chosen anew by the
/// folds that remain among its training clusters, selection and scaling inside. `splits` are those of the lesson. Fails
/// like with_two_folds too.
[[nodiscard]] Result<Eigen::VectorXd> nested_residual(const TrainingSet& training_set,
                                                      const std::vector<FoldData>& splits, const InputPlan& inputs,
                                                      EstimatorOptions estimator, const ProgressSink& progress);

}  // namespace gyrotherm
