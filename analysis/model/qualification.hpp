// SPDX-License-Identifier: Apache-2.0
/// What the experiment trains on its rate run and judges on both runs: the paper's two models, the one that is
/// recommended by rule, and every other method beside them.
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

/// One value for each of the models of the experiment, support vector machines on three-point, multi-point and
/// multi-point-t.
template <class T>
struct PerModel {
  T three_point{}, multi_point{}, multi_point_t{};
};

/// Calls `visit(key, value)` for each model's value, in order; the keys are those of the report.
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

/// A model of the rate run, and how it does on both and later.
struct TrainedModel {
  Model model;
  Verification rate, random;
  double training_s{};                   ///< wall time
  std::vector<Verification> later = {};  ///< on each of the later records, as verify_later() found
};

struct QualificationOptions {
  bool quick = false;      ///< a swarm of 8 particles and 6 iterations, for a try
  bool nested = false;     ///< also Model.nested_leave_cycle_out
  std::uint64_t seed = 0;  ///< of the swarm and of methods that start at random
  int threads = 0;         ///< 0: all. The result does not depend on it
  std::string program_version;
};

/// Trains the three models of the experiment. Fails like train() and verify().
[[nodiscard]] Result<PerModel<TrainedModel>> train_models(const data::RecordedRun& rate,
                                                          const data::RecordedRun& random,
                                                          const QualificationOptions& options,
                                                          const ProgressSink& progress = {});

/// Other methods on the same records.
struct Comparison {
  std::vector<TrainedModel> models;
  std::vector<std::string> warnings;  ///< of what could not be trained on this record: the experiment stands without
};

/// Called before each method is trained, with its name and its inputs.
using ComparisonBegins = std::function<void(std::string_view method, std::string_view inputs)>;

/// Trains every method of the table, each on its default inputs and on those that the table names beside them, but the
/// three models again. Fails with interrupted.
[[nodiscard]] Result<Comparison> train_compared(const data::RecordedRun& rate, const data::RecordedRun& random,
                                                const QualificationOptions& options,
                                                const ComparisonBegins& begins = {}, const ProgressSink& progress = {});

/// All that was trained, and which of it is recommended.
struct Qualification {
  PerModel<TrainedModel> models;
  Comparison comparison;
  Recommendation recommendation = {};
};

/// What the report calls a compared model: "linear-multi-point-t".
[[nodiscard]] std::string name_of_compared(const Model& model);

/// Calls `visit(name, trained)` for all that was trained, the three models first, by the names of the report.
template <class Trained, class Visit>
void for_each_trained(Trained& of, Visit visit) {
  for_each_model(of.models, visit);
  for (auto& trained : of.comparison.models) visit(name_of_compared(trained.model), trained);
}

/// Verifies every model that was trained on records of the same gyro that were made later: whether a model lasts is not
/// seen on the day of its training. Fails like verify().
[[nodiscard]] Result<void> verify_later(Qualification& trained, const std::vector<data::RecordedRun>& later);

/// Fails with usage if a record is the rate run, the random run or given twice.
[[nodiscard]] Result<void> check_apart(const data::Dataset& rate, const data::Dataset& random,
                                       const std::vector<data::RecordedRun>& records);

/// Fails with usage if a further record is of the rate run's program.
[[nodiscard]] Result<void> check_programs(const std::string& rate_profile,
                                          const std::vector<data::RecordedRun>& further);

/// Recommends among all that was trained, by records of programs that it has not seen (recommendation.hpp): each
/// further record, predicted by the model of the rate run, and the rate run, predicted by the same method trained on
/// the further records alone. Nothing of what is judged had a part in scaling, selection, tuning or fitting; the random
/// run, which the headline quotes, is not asked at all. Added to each squared error is what a year's drift of the
/// thermometers will make of the model (drift_in_a_year_deg_per_h). Without further records nothing is trained and
/// nothing recommended. The further records have passed check_apart() and check_programs(). Fails with interrupted, or
/// as verify() does.
[[nodiscard]] Result<Recommendation> recommend_trained(const Qualification& trained, const data::RecordedRun& rate,
                                                       const std::vector<data::RecordedRun>& further,
                                                       const QualificationOptions& options,
                                                       const ComparisonBegins& begins = {},
                                                       const ProgressSink& progress = {});

}  // namespace gyrotherm::model
