#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/model/model.hpp"

namespace gyrotherm {
namespace {

using OrderedJson = nlohmann::ordered_json;

template <class Vector>
OrderedJson numbers(const Vector& values) {
  OrderedJson array = OrderedJson::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) array.push_back(values(i));
  return array;
}

OrderedJson rows(const SampleMatrix& values) {
  OrderedJson array = OrderedJson::array();
  for (Eigen::Index i = 0; i < values.rows(); ++i) array.push_back(numbers(values.row(i)));
  return array;
}

OrderedJson json_of(const Factor& factor) {
  OrderedJson entry{{"kind", name(factor.kind)}, {"first", factor.first}};
  if (factor.kind == FactorKind::gradient) entry["second"] = factor.second;
  return entry;
}

/// The words are for people; the factors say the same where a thermometer's name holds a '-'.
OrderedJson json_of(const std::vector<Term>& terms) {
  OrderedJson array = OrderedJson::array();
  for (const Term& term : terms) {
    OrderedJson factors = OrderedJson::array();
    for (const Factor& factor : term.factors) factors.push_back(json_of(factor));
    array.push_back({{"term", text(term)}, {"factors", std::move(factors)}});
  }
  return array;
}

OrderedJson json_of(const SvrParameters& parameters) {
  return {{"C", parameters.C}, {"sigma", parameters.sigma}, {"epsilon", parameters.epsilon}};
}

OrderedJson json_of(const SvrModel& svr) {
  return {{"form", "svr"},
          {"parameters", json_of(svr.parameters)},
          {"b", svr.b},
          {"relative_gap", svr.relative_gap},
          {"kkt_violation", svr.kkt_violation},
          {"beta", numbers(svr.beta)},
          {"support_vectors", rows(svr.support_vectors)}};
}

OrderedJson json_of(const LinearModel& linear) {
  return {{"form", "linear"}, {"weights", numbers(linear.weights)}, {"b", linear.b}};
}

OrderedJson json_of(const ExpansionModel& expansion) {
  return {{"form", "expansion"},
          {"b", expansion.b},
          {"lengths", numbers(expansion.lengths)},
          {"widths", numbers(expansion.widths)},
          {"weights", numbers(expansion.weights)},
          {"centres", rows(expansion.centres)}};
}

OrderedJson json_of(const NetworkModel& network) {
  return {{"form", "network"},
          {"b", network.b},
          {"out", numbers(network.out)},
          {"offsets", numbers(network.offsets)},
          {"weights", rows(network.weights)}};
}

OrderedJson json_of(const HyperParameters& parameters) {
  OrderedJson array = OrderedJson::array();
  for (const HyperParameter& parameter : parameters) {
    array.push_back({{"name", parameter.name}, {"value", parameter.value}});
  }
  return array;
}

OrderedJson json_of(const std::vector<TrainingRecord>& records) {
  OrderedJson array = OrderedJson::array();
  for (const TrainingRecord& record : records) {
    array.push_back({{"run_id", record.run_id},
                     {"path", record.path},
                     {"profile_name", record.profile_name},
                     {"simulated", record.simulated},
                     {"clusters", record.clusters},
                     {"from_s", record.from_s},
                     {"to_s", record.to_s}});
  }
  return array;
}

OrderedJson json_of(const Selection& selection) {
  return {{"terms", json_of(selection.terms)},
          {"threshold", selection.threshold},
          {"rank", selection.rank},
          {"fallback", selection.fallback},
          {"statement", selection.statement}};
}

OrderedJson json_of(const SwarmSummary& swarm) {
  return {{"end", name(swarm.end)},
          {"best", swarm.best},
          {"best_fitness", swarm.best_fitness},
          {"history", swarm.history},
          {"coordinates_on_edge", swarm.coordinates_on_edge},
          {"evaluations", swarm.evaluations}};
}

OrderedJson json_of(const SwarmOptions& swarm) {
  return {{"particles", swarm.particles},
          {"iterations", swarm.iterations},
          {"omega_max", swarm.omega_max},
          {"omega_min", swarm.omega_min},
          {"c1", swarm.c1},
          {"c2", swarm.c2},
          {"v_max", swarm.v_max},
          {"stall_iterations", swarm.stall_iterations},
          {"stall_gain", swarm.stall_gain},
          {"seed", swarm.seed}};
}

OrderedJson json_of(const TuningOptions& options) {
  return {{"log2_c", {options.log2_c_min, options.log2_c_max}},
          {"log2_sigma", {options.log2_sigma_min, options.log2_sigma_max}},
          {"log2_epsilon", {options.log2_epsilon_min, options.log2_epsilon_max}},
          {"fixed_epsilon", options.fixed_epsilon},
          {"relative_gap", options.svr.relative_gap},
          {"max_newton_steps", options.svr.max_newton_steps},
          {"swarm", json_of(options.swarm)}};
}

OrderedJson json_of(const TuningSummary& tuning, const TuningOptions& options) {
  return {{"best", json_of(tuning.best)},      {"cross_validation_mse", tuning.cross_validation_mse},
          {"uncertified", tuning.uncertified}, {"swarm", json_of(tuning.swarm)},
          {"warnings", tuning.warnings},       {"options", json_of(options)}};
}

OrderedJson json_of(const Figures& figures) {
  return {{"std_deg_per_h", figures.std},
          {"mean_deg_per_h", figures.mean},
          {"rmse_deg_per_h", figures.rmse},
          {"max_abs_deg_per_h", figures.max_abs},
          {"count", figures.count}};
}

OrderedJson json_of(const ReducedSetSummary& reduction) {
  return {{"vectors_before", reduction.vectors_before},
          {"vectors", reduction.vectors},
          {"bound_deg_per_h", reduction.bound_deg_per_h},
          {"max_change_deg_per_h", reduction.max_change_deg_per_h},
          {"rms_change_deg_per_h", reduction.rms_change_deg_per_h},
          {"clusters", reduction.clusters}};
}

/// Of one input each: what a person reading the file wants side by side.
OrderedJson json_of_inputs(const Model& model) {
  OrderedJson array = json_of(model.terms);
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(model.terms.size()); ++i) {
    array[i]["mean"] = model.scaling.mean(i);
    array[i]["std"] = model.scaling.std(i);
    array[i]["min"] = model.input_min(i);
    array[i]["max"] = model.input_max(i);
  }
  return array;
}

}  // namespace

std::string to_json(const Model& model) {
  OrderedJson json{
      {"schema", kModelSchema},
      {"program_version", model.program_version},
      {"inputs", model.inputs},
      {"method", model.method},
      {"quick", model.quick},
      {"cluster_length_s", model.cluster_length_s},
      {"terms", json_of_inputs(model)},
      {"target", {{"mean_deg_per_h", model.target_mean_deg_per_h}, {"std_deg_per_h", model.target_std_deg_per_h}}},
      {"trained_on", json_of(model.trained_on)},
      {"folds", model.folds},
      {"in_sample", json_of(model.in_sample)},
      {"leave_cycle_out", json_of(model.leave_cycle_out)},
      {"leave_cycle_out_residual_deg_per_h", numbers(model.leave_cycle_out_residual)},
      {"warnings", model.warnings},
      {"hyper_parameters", json_of(model.hyper_parameters)},
      {"effective_parameters", model.effective_parameters},
      {"particulars", model.particulars},
      {"function", std::visit([](const auto& function) { return json_of(function); }, model.function)}};
  if (!model.selection.terms.empty()) json["selection"] = json_of(model.selection);
  if (std::isfinite(model.residual_std_deg_per_h)) json["residual_std_deg_per_h"] = model.residual_std_deg_per_h;
  if (model.nested_leave_cycle_out) json["nested_leave_cycle_out"] = json_of(*model.nested_leave_cycle_out);
  if (model.tuning.swarm.end != SwarmEnd::was_not_run) json["tuning"] = json_of(model.tuning, model.tuning_options);
  if (model.reduction) json["reduction"] = json_of(*model.reduction);
  return json.dump(1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace gyrotherm
