#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "analysis/methods/method.hpp"
#include "report/json_pieces.hpp"
#include "report/report_json_parts.hpp"

namespace gyrotherm {
namespace {

using Json = nlohmann::ordered_json;

Json swarm_section(const SwarmOptions& options, const SwarmSummary& summary) {
  return {{"particles", options.particles},
          {"iterations", options.iterations},
          {"omega_max", options.omega_max},
          {"omega_min", options.omega_min},
          {"c1", options.c1},
          {"c2", options.c2},
          {"v_max", options.v_max},
          {"end", name(summary.end)},
          {"evaluations", summary.evaluations}};
}

Json tuning(const Model& model) {
  const auto& svr = std::get<SvrModel>(model.function);
  const TuningOptions& options = model.tuning_options;
  Json json = {{"seed", options.swarm.seed}, {"swarm", swarm_section(options.swarm, model.tuning.swarm)}};
  json["bounds"] = {{"log2_c", {options.log2_c_min, options.log2_c_max}},
                    {"log2_sigma", {options.log2_sigma_min, options.log2_sigma_max}},
                    {"log2_epsilon", {options.log2_epsilon_min, options.log2_epsilon_max}},
                    {"fixed_epsilon", options.fixed_epsilon}};
  json["fitness"] = "mean squared error on held-out folds, (deg/h)^2";
  json["folds"] = model.folds;
  json["history"] = model.tuning.swarm.history;
  json["C"] = svr.parameters.C;
  json["sigma"] = svr.parameters.sigma;
  json["epsilon"] = svr.parameters.epsilon;
  json["epsilon_deg_per_h"] = svr.parameters.epsilon * model.target_std_deg_per_h;
  json["support_vectors"] = svr.support_vectors.rows();
  json["certified_gap"] = svr.relative_gap;
  json["kkt_violation"] = svr.kkt_violation;
  json["warnings"] = model.tuning.warnings;
  return json;
}

Json model_section(const Model& model) {
  Json json = {{"inputs", model.inputs},
               {"method", model.method},
               {"terms", Json::array()},
               {"rank", rank_of(model.terms)},
               {"stored_numbers", stored_numbers(model)},
               {"effective_parameters", json_if_known<Json>(model.effective_parameters)},
               {"residual_std_deg_per_h", model.residual_std_deg_per_h}};
  for (const Term& term : model.terms) json["terms"].push_back(text(term));
  json["trained_on"] = Json::array();
  for (const TrainingRecord& record : model.trained_on) {
    json["trained_on"].push_back({{"run_id", record.run_id},
                                  {"profile", record.profile_name},
                                  {"simulated", record.simulated},
                                  {"clusters", record.clusters}});
  }
  return json;
}

Json optional_figures(const std::optional<Figures>& figures) {
  return figures ? json_of<Json>(*figures) : Json(nullptr);
}

Json method_row(const ComparedMethod& row) {
  return {{"name", row.name},
          {"inputs", row.inputs},
          {"method", row.method},
          {"title", row.title},
          {"citation", row.citation},
          {"in_sample", json_of<Json>(row.in_sample)},
          {"leave_cycle_out", json_of<Json>(row.leave_cycle_out)},
          {"nested_leave_cycle_out", optional_figures(row.nested)},
          {"random", json_of<Json>(row.random)},
          {"stored_numbers", row.stored_numbers},
          {"effective_parameters", json_if_known<Json>(row.effective_parameters)}};
}

}  // namespace

std::string leave_cycle_out_json(const ReportedModels& models) {
  Json json = {{"nested", false}, {"folds", models.multi_point.folds}};
  for (const auto& [key, model] : by_key(models)) json[key] = json_of<Json>(model->leave_cycle_out);
  return text_of(json);
}

std::string nested_leave_cycle_out_json(const ReportedModels& models) {
  Json json = {{"nested", true}, {"folds", models.multi_point.folds}};
  for (const auto& [key, model] : by_key(models)) json[key] = optional_figures(model->nested_leave_cycle_out);
  return text_of(json);
}

std::string models_json(const ReportedModels& models) {
  Json json;
  for (const auto& [key, model] : by_key(models)) json[key] = model_section(*model);
  return text_of(json);
}

std::string tuning_json(const ReportedModels& models) {
  Json json;
  for (const auto& [key, model] : by_key(models)) json[key] = tuning(*model);
  return text_of(json);
}

std::string methods_json(const ReportInput& input) {
  Json array = Json::array();
  const auto models = by_key(input.models);
  const auto on_rate = by_key(input.rate), on_random = by_key(input.random);
  for (std::size_t k = 0; k < models.size(); ++k) {
    const auto& [key, model] = models[k];
    array.push_back(
        method_row(compared_method(key, *model, on_rate[k].second->compensated, on_random[k].second->compensated)));
  }
  for (const ComparedMethod& row : input.compared) array.push_back(method_row(row));
  return text_of(array);
}

int stored_numbers(const Model& model) {
  const auto inputs = static_cast<int>(model.terms.size());
  constexpr int kPerInput = 2, kOfTarget = 2;  // mean and STD each
  return numbers_in(model.function) + kPerInput * inputs + kOfTarget;
}

ComparedMethod compared_method(std::string name, const Model& model, const Figures& in_sample, const Figures& random) {
  ComparedMethod row{.name = std::move(name),
                     .inputs = model.inputs,
                     .method = model.method,
                     .in_sample = in_sample,
                     .leave_cycle_out = model.leave_cycle_out,
                     .random = random,
                     .nested = model.nested_leave_cycle_out,
                     .stored_numbers = stored_numbers(model),
                     .effective_parameters = model.effective_parameters};
  if (const auto method = find_method(model.method)) {
    row.title = (*method)->title;
    row.citation = (*method)->citation;
  }
  return row;
}

}  // namespace gyrotherm
