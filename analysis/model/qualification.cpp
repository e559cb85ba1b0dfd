// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/qualification.hpp"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "analysis/methods/method.hpp"
#include "analysis/model/training.hpp"

namespace gyrotherm::model {
namespace {

constexpr std::string_view kMethod = "svr";

/// What is trained, and how it is called while it is.
struct Task {
  std::string stage, method, inputs;
};

Result<TrainedModel> train_one(const Task& task, const data::RecordedRun& rate, const data::RecordedRun& random,
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
  const auto began = std::chrono::steady_clock::now();
  auto model = train({rate.dataset}, {rate.clusters}, training, staged);
  if (!model) return failure(model.error());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  auto on_rate = verify(*model, rate.dataset, rate.clusters);
  if (!on_rate) return failure(on_rate.error());
  auto on_random = verify(*model, random.dataset, random.clusters);
  if (!on_random) return failure(on_random.error());
  return TrainedModel{std::move(*model), std::move(*on_rate), std::move(*on_random), took.count()};
}

std::vector<Task> tasks_of_comparison() {
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

}  // namespace

Result<PerModel<TrainedModel>> train_models(const data::RecordedRun& rate, const data::RecordedRun& random,
                                            const QualificationOptions& options, const ProgressSink& progress) {
  PerModel<TrainedModel> models;
  for (const auto& [inputs, place] : {std::pair{"three-point", &models.three_point},
                                      {"multi-point", &models.multi_point},
                                      {"multi-point-t", &models.multi_point_t}}) {
    const Task task{fmt::format("training {}", inputs), std::string(kMethod), inputs};
    auto model = train_one(task, rate, random, options, progress);
    if (!model) return failure(model.error());
    *place = std::move(*model);
  }
  return models;
}

Result<Comparison> train_compared(const data::RecordedRun& rate, const data::RecordedRun& random,
                                  const QualificationOptions& options, const ComparisonBegins& begins,
                                  const ProgressSink& progress) {
  Comparison comparison;
  for (const Task& task : tasks_of_comparison()) {
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
