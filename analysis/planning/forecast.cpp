// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/forecast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/model/qualification.hpp"
#include "analysis/planning/mission_uncertainty.hpp"

namespace gyrotherm::planning {
Result<Forecast> Forecast::make(const data::RecordedRun& reference, const ProgramPath& mission,
                                const ProgressSink& progress) {
  const double length_s = reference.clusters.length_s;
  auto response = fit_response(reference.dataset, length_s);
  if (!response) return failure(response.error());
  auto trained = model::train_recommended(reference, progress);
  if (!trained) return failure(trained.error());
  data::Clusters on_mission = predict_clusters(*response, mission);
  Forecast forecast(std::move(*trained), std::move(*response), std::move(on_mission));
  const auto stated = mission_uncertainty(forecast.reference_, forecast.mission_);
  if (!stated) return failure(stated.error());
  forecast.reference_deg_per_h_ = *stated;
  const auto learnt = forecast.learn(recorded_path(reference.dataset, length_s));
  if (!learnt) return failure(learnt.error());
  forecast.reference_variance_ = learnt->on_mission;
  return forecast;
}

Result<Forecast::Learnt> Forecast::learn(const ProgramPath& program) const {
  Learnt learnt{.model = reference_, .on_mission = 0, .in_training = 0};
  learnt.model.variance->posterior.setIdentity();
  learnt.model.input_min.setConstant(std::numeric_limits<double>::infinity());
  learnt.model.input_max.setConstant(-std::numeric_limits<double>::infinity());
  const data::Clusters clusters = predict_clusters(response_, program);
  if (const auto added = add_clusters(learnt.model, clusters); !added) return failure(added.error());
  const auto on_mission = mean_variance(learnt.model, mission_), in_training = mean_variance(learnt.model, clusters);
  if (!on_mission || !in_training) return failure(on_mission ? in_training.error() : on_mission.error());
  learnt.on_mission = *on_mission;
  learnt.in_training = *in_training;
  return learnt;
}

Result<double> Forecast::expanded_after(const ProgramPath& program) const {
  auto learnt = learn(program);
  if (!learnt) return failure(learnt.error());
  const double ratio = reference_variance_ > 0 ? learnt->on_mission / reference_variance_ : 1;
  scale_form(learnt->model, ratio);
  for (model::BudgetRow& row : learnt->model.uncertainty->budget.rows)
    if (row.source == model::Source::turn_on) row.sensitivity = std::sqrt(1 + 1.0 / std::max(1, count_starts(program)));
  learnt->model.uncertainty->variance_in_training = learnt->in_training;
  return mission_uncertainty(learnt->model, mission_);
}

}  // namespace gyrotherm::planning
