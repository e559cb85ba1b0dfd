// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/forecast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/model/prior_training.hpp"
#include "analysis/model/qualification.hpp"
#include "analysis/planning/mission_uncertainty.hpp"

namespace gyrotherm::planning {

Result<Forecast> Forecast::make(const data::RecordedRun& reference, const ProgramPath& mission,
                                const ProgressSink& progress) {
  auto trained = model::train_recommended(reference, progress);
  if (!trained) return failure(trained.error());
  const Eigen::Index features = trained->variance->posterior.rows(), inputs = trained->input_min.size();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Start start{.covariance = Eigen::MatrixXd::Identity(features, features),
              .input_min = Eigen::RowVectorXd::Constant(inputs, kInfinity),
              .input_max = Eigen::RowVectorXd::Constant(inputs, -kInfinity)};
  return assemble(std::move(*trained), std::move(start), reference, mission);
}

Result<Forecast> Forecast::make_with_prior(const population::TypePrior& prior, const data::RecordedRun& reference,
                                           const ProgramPath& mission) {
  auto trained = model::train_with_prior(prior, {reference.dataset}, {reference.clusters}, {});
  if (!trained) return failure(trained.error());
  std::vector<Eigen::Index> slopes_first;
  for (Eigen::Index i = 1; i < prior.next_unit.mean.size(); ++i) slopes_first.push_back(i);
  slopes_first.push_back(0);
  Start start{.covariance = prior.next_unit.covariance(slopes_first, slopes_first),
              .input_min = prior.input_min,
              .input_max = prior.input_max};
  return assemble(std::move(*trained), std::move(start), reference, mission);
}

Result<Forecast> Forecast::assemble(model::Model trained, Start start, const data::RecordedRun& reference,
                                    const ProgramPath& mission) {
  auto response = fit_response(reference.dataset, reference.clusters.length_s);
  if (!response) return failure(response.error());
  data::Clusters on_mission = predict_clusters(*response, mission);
  Forecast forecast(std::move(trained), std::move(start), std::move(*response), std::move(on_mission));
  const auto stated = mission_uncertainty(forecast.reference_, forecast.mission_);
  if (!stated) return failure(stated.error());
  forecast.reference_deg_per_h_ = *stated;
  const auto learnt = forecast.learn(recorded_path(reference.dataset, reference.clusters.length_s));
  if (!learnt) return failure(learnt.error());
  forecast.reference_variance_ = learnt->on_mission;
  return forecast;
}

Result<Forecast::Learnt> Forecast::learn(const ProgramPath& program) const {
  Learnt learnt{.model = reference_, .on_mission = 0, .in_training = 0};
  learnt.model.variance->posterior = start_.covariance;
  learnt.model.input_min = start_.input_min;
  learnt.model.input_max = start_.input_max;
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
