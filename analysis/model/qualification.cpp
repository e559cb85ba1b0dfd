// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/qualification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "analysis/methods/method.hpp"
#include "analysis/model/training.hpp"
#include "analysis/model/uncertainty.hpp"

namespace gyrotherm::model {
namespace {

constexpr std::string_view kMethod = "svr";

/// A training of one method on one set of inputs, and the stage name for the progress.
struct Task {
  std::string stage, method, inputs;
};

std::string join_name(std::string_view method, std::string_view inputs) { return fmt::format("{}-{}", method, inputs); }

Result<Model> train_on(const std::vector<data::RecordedRun>& runs, const Task& task,
                       const QualificationOptions& options, const ProgressSink& progress) {
  TrainingOptions training;
  training.inputs = task.inputs;
  training.method = task.method;
  training.nested = options.nested;
  training.quick = options.quick;
  training.program_version = options.program_version;
  training.tuning.swarm.seed = options.seed;
  training.tuning.swarm.threads = options.threads;
  const auto staged = [&](std::string_view stage, double fraction) {
    return !progress || progress(fmt::format("{}: {}", task.stage, stage), fraction);
  };
  std::vector<data::Dataset> datasets;
  std::vector<data::Clusters> clusters;
  for (const data::RecordedRun& run : runs) {
    datasets.push_back(run.dataset);
    clusters.push_back(run.clusters);
  }
  return train(datasets, clusters, training, staged);
}

Result<TrainedModel> train_one(const Task& task, const data::RecordedRun& rate, const data::RecordedRun& random,
                               const QualificationOptions& options, const ProgressSink& progress) {
  const auto began = std::chrono::steady_clock::now();
  auto model = train_on({rate}, task, options, progress);
  if (!model) return failure(model.error());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  auto on_rate = verify(*model, rate.dataset, rate.clusters);
  if (!on_rate) return failure(on_rate.error());
  auto on_random = verify(*model, random.dataset, random.clusters);
  if (!on_random) return failure(on_random.error());
  if (data::sample_interval_s(random.dataset) == 1) {
    auto streamed = evaluate_stream(*model, random.dataset, random.clusters, on_random->residual_deg_per_h);
    if (streamed) on_random->streamed = std::move(*streamed);
  }
  return TrainedModel{std::move(*model), std::move(*on_rate), std::move(*on_random), took.count()};
}

std::vector<Task> comparison_tasks(MethodScope scope) {
  if (scope == MethodScope::recommended)
    return {{fmt::format("training {}", kRecommendedMethod), std::string(kRecommendedMethod),
             std::string(kRecommendedInputs)}};
  std::vector<Task> tasks;
  const auto add = [&](std::string_view method, std::string_view inputs) {
    if (!inputs.empty()) tasks.push_back({"", std::string(method), std::string(inputs)});
  };
  for (const methods::Method& method : methods::methods()) {
    if (method.name != kMethod) add(method.name, method.inputs);
    for (const std::string_view inputs : method.compared_on) add(method.name, inputs);
  }
  for (std::size_t k = 0; k < tasks.size(); ++k)
    tasks[k].stage = fmt::format("comparing {} of {}, {}", k + 1, tasks.size(), tasks[k].method);
  return tasks;
}

/// A model of the ramp run and its name in the report.
struct NamedModel {
  std::string name;
  const TrainedModel& trained;
};

std::vector<NamedModel> named_models(const Qualification& qualification) {
  std::vector<NamedModel> all;
  for_each_trained(qualification, [&](const std::string& name, const TrainedModel& trained) {
    all.push_back({name, trained});
  });
  return all;
}

/// Returns the mean squared error on a run, plus the variance caused by a year of thermometer drift, which records of a
/// few weeks cannot reveal.
Result<double> compute_run_error(const Model& model, const data::RecordedRun& run) {
  return verify(model, run.dataset, run.clusters).map([&](const Verification& verification) {
    return std::pow(verification.compensated.rmse, 2) + std::pow(yearly_drift_deg_per_h(model, run.dataset), 2);
  });
}

/// Computes the mean squared error of the ramp run's model on each further record, and that of a model of all further
/// records on the ramp run. The latter is NaN if the method cannot learn from the further records.
Result<Candidate> evaluate_candidate(const NamedModel& named, const data::RecordedRun& rate,
                                     const std::vector<data::RecordedRun>& further, const QualificationOptions& options,
                                     const ProgressSink& progress) {
  const Model& model = named.trained.model;
  Candidate candidate{.name = named.name, .stored_numbers = stored_numbers(model), .held_out_mse = {}};
  for (const data::RecordedRun& run : further) {
    const auto mse = compute_run_error(model, run);
    if (!mse) return failure(mse.error());
    candidate.held_out_mse.push_back(*mse);
  }
  QualificationOptions once = options;
  once.nested = false;
  const auto other = train_on(further, {"choosing " + named.name, model.method, model.inputs}, once, progress);
  if (!other && other.error().kind == FaultKind::interrupted) return failure(other.error());
  const auto mse = other ? compute_run_error(*other, rate) : Result<double>(std::nan(""));
  if (!mse) return failure(mse.error());
  candidate.held_out_mse.push_back(*mse);
  return candidate;
}

/// Names the recommended method if it is among the trained models. There is no record to compare them on.
Recommendation recommend_uncompared(const Qualification& trained) {
  Recommendation found = recommend({});
  const std::string name = join_name(kRecommendedMethod, kRecommendedInputs);
  const auto all = named_models(trained);
  if (std::ranges::find(all, name, &NamedModel::name) == all.end()) return found;
  found.recommended = name;
  found.statement =
      "which the rule chose for 17 of 20 virtual gyros (docs/evaluation.md); the rule was not applied to this gyro, "
      "because there is no independent record for the choice; supply one with --further";
  return found;
}

}  // namespace

Result<Model> train_recommended(const data::RecordedRun& recorded, const ProgressSink& progress) {
  TrainingOptions options;
  options.inputs = kRecommendedInputs;
  options.method = kRecommendedMethod;
  return train({recorded.dataset}, {recorded.clusters}, options, progress);
}

std::string compared_name(const Model& model) { return join_name(model.method, model.inputs); }

Result<void> check_apart(const data::Dataset& rate, const data::Dataset& random,
                         const std::vector<data::RecordedRun>& records) {
  std::vector<std::string> run_ids{rate.run_id, random.run_id};
  for (const data::RecordedRun& run : records) {
    if (std::ranges::count(run_ids, run.dataset.run_id) > 0)
      return failure(FaultKind::usage, run.dataset.path,
                     "a further or later record must not be the ramp run or the random run, or be given twice");
    if (auto one_gyro = check_same_gyro(run.dataset, rate, "the ramp run"); !one_gyro) return one_gyro;
    run_ids.push_back(run.dataset.run_id);
  }
  return {};
}

Result<void> check_profiles(const std::string& rate_profile, const std::vector<data::RecordedRun>& further) {
  for (const data::RecordedRun& run : further)
    if (run.dataset.profile_name == rate_profile)
      return failure(FaultKind::usage, run.dataset.path,
                     "a further record must have a different profile from the ramp run");
  return {};
}

Result<void> verify_later(Qualification& trained, const std::vector<data::RecordedRun>& later) {
  Result<void> done;
  for_each_trained(trained, [&](const std::string&, TrainedModel& one) {
    one.later.clear();
    for (const data::RecordedRun& run : later) {
      if (!done) return;
      auto verified = verify(one.model, run.dataset, run.clusters);
      if (!verified) {
        done = failure(verified.error());
        return;
      }
      one.later.push_back(std::move(*verified));
    }
  });
  return done;
}

Result<Recommendation> recommend_trained(const Qualification& trained, const data::RecordedRun& rate,
                                         const std::vector<data::RecordedRun>& further,
                                         const QualificationOptions& options, const ComparisonCallback& begins,
                                         const ProgressSink& progress) {
  if (further.empty()) return recommend_uncompared(trained);
  std::vector<Candidate> candidates;
  for (const NamedModel& named : named_models(trained)) {
    if (begins) begins(named.trained.model.method, named.trained.model.inputs);
    auto candidate = evaluate_candidate(named, rate, further, options, progress);
    if (!candidate) return failure(candidate.error());
    candidates.push_back(std::move(*candidate));
  }
  return recommend(candidates);
}

Result<PerModel<TrainedModel>> train_models(const data::RecordedRun& rate, const data::RecordedRun& random,
                                            const QualificationOptions& options, const ProgressSink& progress) {
  PerModel<TrainedModel> models;
  for (const auto& [inputs, target] : {std::pair{"three-point", &models.three_point},
                                       {"multi-point", &models.multi_point},
                                       {"multi-point-t", &models.multi_point_t}}) {
    const Task task{fmt::format("training {}", inputs), std::string(kMethod), inputs};
    auto model = train_one(task, rate, random, options, progress);
    if (!model) return failure(model.error());
    *target = std::move(*model);
  }
  return models;
}

Result<Comparison> train_compared(const data::RecordedRun& rate, const data::RecordedRun& random, MethodScope scope,
                                  const QualificationOptions& options, const ComparisonCallback& begins,
                                  const ProgressSink& progress) {
  Comparison comparison;
  for (const Task& task : comparison_tasks(scope)) {
    if (begins) begins(task.method, task.inputs);
    auto model = train_one(task, rate, random, options, progress);
    if (model) {
      comparison.models.push_back(std::move(*model));
      continue;
    }
    if (model.error().kind == FaultKind::interrupted) return failure(model.error());
    comparison.warnings.push_back(
        fmt::format("{} on {} is not compared: {}", task.method, task.inputs, text(model.error())));
  }
  return comparison;
}

}  // namespace gyrotherm::model
