// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/assessment.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "analysis/model/prior_training.hpp"
#include "analysis/model/qualification.hpp"
#include "analysis/planning/mission_uncertainty.hpp"
#include "analysis/planning/thermal_response.hpp"
#include "analysis/population/type_prior.hpp"

namespace gyrotherm::planning {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// Trains the recommended model; no value if the record is too short for it.
Result<std::optional<model::Model>> train_own(const data::RecordedRun& recorded, const ProgressSink& progress) {
  auto model = model::train_recommended(recorded, progress);
  if (model) return std::optional(std::move(*model));
  if (model.error().kind == FaultKind::interrupted) return failure(model.error());
  return std::nullopt;
}

/// Trains with the type prior; no value without a prior. Fails with interrupted before the training, or like
/// train_with_prior().
Result<std::optional<model::Model>> train_from_prior(const data::RecordedRun& recorded, const std::string& text,
                                                     const ProgressSink& progress) {
  if (text.empty()) return std::nullopt;
  if (!should_continue(progress, "type prior", 0))
    return failure(FaultKind::interrupted, "type prior", "stopped on request");
  const auto prior = population::type_prior_from_json(text, "prior");
  if (!prior) return failure(prior.error());
  auto model = model::train_with_prior(*prior, {recorded.dataset}, {recorded.clusters}, {});
  if (!model) return failure(model.error());
  return std::optional(std::move(*model));
}

/// The block as clusters that would follow a recorded run.
struct Extension {
  data::Clusters clusters;
  int power_ons{};
};

Extension extend(const ThermalResponse& response, const ProgramPath& recorded, const ProgramPath& block) {
  const ProgramPath path = join(recorded, block);
  return {predict_clusters(response, path, recorded.set_point_c.size()), count_starts(path) - count_starts(recorded)};
}

/// Returns the model with a budget that does not depend on the noise of its record; see Assessment::gains.
model::Model with_nominal_budget(model::Model model) {
  constexpr double kFormToTurnOn = 3;
  auto& rows = model.uncertainty->budget.rows;
  std::erase_if(rows, [](const model::BudgetRow& row) { return row.source != model::Source::turn_on; });
  if (rows.empty()) return model;
  model::BudgetRow form{.source = model::Source::model_form};
  form.standard_uncertainty = kFormToTurnOn * rows.front().standard_uncertainty;
  rows.push_back(std::move(form));
  model.uncertainty->variance_in_training = std::numeric_limits<double>::quiet_NaN();
  return model;
}

/// Returns the uncertainty of a model that is expected after each block, °/h.
Result<std::vector<double>> expect_blocks(const model::Model& model, const data::Clusters& mission,
                                          const std::vector<Extension>& blocks) {
  std::vector<double> all;
  for (const Extension& block : blocks) {
    const auto after = expected_after(model, mission, block.clusters, block.power_ons);
    if (!after) return failure(after.error());
    const auto u = mission_uncertainty(*after, mission);
    if (!u) return failure(u.error());
    all.push_back(*u);
  }
  return all;
}

/// Lowers the uncertainties of the assessment to those of a model, and raises the gains, where these are lower and
/// higher.
Result<void> add_model(Assessment& assessment, const model::Model& model, const data::Clusters& mission,
                       const std::vector<Extension>& blocks) {
  const model::Model nominal = with_nominal_budget(model);
  const auto now = mission_uncertainty(model, mission), nominal_now = mission_uncertainty(nominal, mission);
  if (!now || !nominal_now) return failure(now ? nominal_now.error() : now.error());
  const auto after = expect_blocks(model, mission, blocks), nominal_after = expect_blocks(nominal, mission, blocks);
  if (!after || !nominal_after) return failure(after ? nominal_after.error() : after.error());
  assessment.u_now_deg_per_h = std::min(assessment.u_now_deg_per_h, *now);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    assessment.u_after_deg_per_h[i] = std::min(assessment.u_after_deg_per_h[i], (*after)[i]);
    assessment.gains[i] = std::max(assessment.gains[i], 1 - (*nominal_after)[i] / *nominal_now);
  }
  return {};
}

}  // namespace

Result<Assessment> assess(const data::RecordedRun& recorded, const ProgramPath& mission,
                          std::span<const ProgramPath> blocks, const AssessmentOptions& options,
                          const ProgressSink& progress) {
  const double length_s = recorded.clusters.length_s;
  const auto response = fit_response(recorded.dataset, length_s);
  if (!response) return failure(response.error());
  const data::Clusters on_mission = predict_clusters(*response, mission);
  const ProgramPath so_far = recorded_path(recorded.dataset, length_s);
  std::vector<Extension> extensions;
  for (const ProgramPath& block : blocks) extensions.push_back(extend(*response, so_far, block));
  Assessment assessment{.u_now_deg_per_h = kUnknown,
                        .u_after_deg_per_h = std::vector<double>(blocks.size(), kUnknown),
                        .gains = std::vector<double>(blocks.size(), 0),
                        .uses_prior = false};
  const auto own = train_own(recorded, progress);
  if (!own) return failure(own.error());
  if (*own)
    if (const auto added = add_model(assessment, **own, on_mission, extensions); !added) return failure(added.error());
  const double without_prior = assessment.u_now_deg_per_h;
  const auto from_prior = train_from_prior(recorded, options.prior, progress);
  if (!from_prior) return failure(from_prior.error());
  if (*from_prior)
    if (const auto added = add_model(assessment, **from_prior, on_mission, extensions); !added)
      return failure(added.error());
  assessment.uses_prior = assessment.u_now_deg_per_h < without_prior;
  return assessment;
}

}  // namespace gyrotherm::planning
