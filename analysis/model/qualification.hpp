// SPDX-License-Identifier: Apache-2.0
/// Training of models on the ramp run of the experiment, and verification on both runs: the three models of the
/// experiment, the recommended one or all other methods beside them, and the recommendation of one model by rule.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/recommendation.hpp"
#include "analysis/model/verification.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// One value for each model of the experiment: support vector machines on three-point, multi-point and multi-point-t.
template <class T>
struct PerModel {
  T three_point{}, multi_point{}, multi_point_t{};
};

/// Calls `visit(key, value)` for each model's value, in order, with the keys of the report.
template <class Values, class Visit>
void for_each_model(Values& of, Visit visit) {
  visit("three_point", of.three_point);
  visit("multi_point", of.multi_point);
  visit("multi_point_t", of.multi_point_t);
}
template <class T>
void describe(auto& form, PerModel<T>& of) {
  for_each_model(of, [&](const char* key, T& value) { form(key, value); });
}
template <class T>
void describe(auto& form, const PerModel<T>& of) {
  for_each_model(of, [&](const char* key, const T& value) { form(key, value); });
}

/// A model trained on the ramp run, verified on both runs and on later records.
struct TrainedModel {
  Model model;
  Verification rate, random;
  double training_s{};                   ///< wall time
  std::vector<Verification> later = {};  ///< one per later record
};

struct QualificationOptions {
  bool quick = false;   ///< 8 particles and 6 iterations
  bool nested = false;  ///< also Model.nested_leave_cycle_out
  /// Seed of the swarm and of methods with random starts.
  std::uint64_t seed = 0;
  /// Number of threads; 0 uses all. The result does not depend on it.
  int threads = 0;
  std::string program_version;
};

/// Trains the three models of the experiment. Fails like train() and verify().
[[nodiscard]] Result<PerModel<TrainedModel>> train_models(const data::RecordedRun& rate,
                                                          const data::RecordedRun& random,
                                                          const QualificationOptions& options,
                                                          const ProgressSink& progress = {});

/// The method that the rule chose for most gyros of docs/evaluation.md, and its inputs.
inline constexpr std::string_view kRecommendedMethod = "ridge-u";
inline constexpr std::string_view kRecommendedInputs = "thermal-history";

/// Trains this method on one record. Fails like train().
[[nodiscard]] Result<Model> train_recommended(const data::RecordedRun& recorded, const ProgressSink& progress = {});

/// Methods that are trained beside the models of the experiment.
enum class MethodScope {
  recommended,  ///< kRecommendedMethod alone
  all,          ///< every method of the table
};

/// Other methods on the same records.
struct Comparison {
  std::vector<TrainedModel> models;
  /// One warning per method that could not be trained on this record. The qualification continues without it.
  std::vector<std::string> warnings;
};

/// Called before each method is trained, with its name and inputs.
using ComparisonCallback = std::function<void(std::string_view method, std::string_view inputs)>;

/// Trains the recommended method, or every method of the table on its default inputs and on those that the table lists
/// for comparison, except the three models of train_models(). Fails with interrupted.
[[nodiscard]] Result<Comparison> train_compared(const data::RecordedRun& rate, const data::RecordedRun& random,
                                                MethodScope scope, const QualificationOptions& options,
                                                const ComparisonCallback& begins = {},
                                                const ProgressSink& progress = {});

/// All trained models and the recommendation.
struct Qualification {
  PerModel<TrainedModel> models;
  Comparison comparison;
  Recommendation recommendation = {};
};

/// Returns the name of a compared model in the report, such as "linear-multi-point-t".
[[nodiscard]] std::string compared_name(const Model& model);

/// Calls `visit(name, trained)` for all trained models, the three models first, with the names of the report.
template <class Trained, class Visit>
void for_each_trained(Trained& of, Visit visit) {
  for_each_model(of.models, visit);
  for (auto& trained : of.comparison.models) visit(compared_name(trained.model), trained);
}

/// Verifies every trained model on records of the same gyro that were made later, since records of the training day do
/// not show how long a model remains valid. Fails like verify().
[[nodiscard]] Result<void> verify_later(Qualification& trained, const std::vector<data::RecordedRun>& later);

/// Fails with usage if a record is the ramp run or the random run, or is given twice.
[[nodiscard]] Result<void> check_apart(const data::Dataset& rate, const data::Dataset& random,
                                       const std::vector<data::RecordedRun>& records);

/// Fails with usage if a further record has the profile of the ramp run.
[[nodiscard]] Result<void> check_profiles(const std::string& rate_profile,
                                          const std::vector<data::RecordedRun>& further);

/// Recommends one of all trained models, compared on records with profiles that the models have not seen
/// (recommendation.hpp): each further record is predicted by the model of the ramp run, and the ramp run is predicted
/// by the same method trained only on the further records. The comparison never uses data that were used in a model's
/// scaling, selection, tuning or fitting. The random run, from which the headline results come, is not used at all.
/// Each squared error includes the effect of the thermometers' drift in a year (yearly_drift_deg_per_h). Without
/// further records nothing more is trained: the recommended method is named if it is among the trained models, and the
/// statement says that it was not compared on this gyro. The further records must have passed check_apart() and
/// check_profiles(). Fails with interrupted, or like verify().
[[nodiscard]] Result<Recommendation> recommend_trained(const Qualification& trained, const data::RecordedRun& rate,
                                                       const std::vector<data::RecordedRun>& further,
                                                       const QualificationOptions& options,
                                                       const ComparisonCallback& begins = {},
                                                       const ProgressSink& progress = {});

}  // namespace gyrotherm::model
