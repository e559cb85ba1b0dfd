// SPDX-License-Identifier: Apache-2.0
/// The model file. One description of every part serves both writing and reading.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "analysis/model/model.hpp"
#include "core/json.hpp"

namespace gyrotherm {
namespace {

/// Range of permitted magnitudes. Within it, inputs in standard deviations, weights in °/h and their squares neither
/// overflow nor underflow.
constexpr double kLeastMagnitude = 1e-30, kGreatestMagnitude = 1e30;

template <class T>
InRange<T> bounded_number(T& value) {
  return {value, -kGreatestMagnitude, kGreatestMagnitude, false, "expected a number with magnitude at most 1e30"};
}
template <class T>
InRange<T> positive_number(T& value) {
  return {value, kLeastMagnitude, kGreatestMagnitude, false, "expected a number from 1e-30 to 1e30"};
}

bool are_positive_numbers(const auto& values) {
  return (values.array() >= kLeastMagnitude && values.array() <= kGreatestMagnitude).all();
}

bool is_within_limits(const tracking::BiasNoise& noise) {
  return noise.angle_random_walk_deg_per_sqrt_h >= kLeastMagnitude &&
         noise.angle_random_walk_deg_per_sqrt_h <= kGreatestMagnitude &&
         noise.instability_deg_per_h <= kGreatestMagnitude &&
         noise.rate_random_walk_deg_per_h_per_sqrt_h <= kGreatestMagnitude &&
         noise.start_deg_per_h <= kGreatestMagnitude;
}

}  // namespace

/// A vector as a JSON array.
template <class Vector>
struct JsonVector {
  static Json write(const Vector& values) { return std::vector<double>(values.begin(), values.end()); }
  static void read(const JsonNode& node, Vector& values) {
    const std::vector<double> numbers = node.numbers();
    const auto invalid =
        std::ranges::find_if(numbers, [](double number) { return !(std::abs(number) <= kGreatestMagnitude); });
    if (invalid != numbers.end())
      node.elements()[static_cast<std::size_t>(invalid - numbers.begin())].note_error(
          "expected a number with magnitude at most 1e30");
    values = Eigen::Map<const Vector>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
  }
};
template <>
struct JsonValue<Eigen::VectorXd> : JsonVector<Eigen::VectorXd> {};
template <>
struct JsonValue<Eigen::RowVectorXd> : JsonVector<Eigen::RowVectorXd> {};

/// A matrix with a given number of columns, as an array of rows.
template <class Matrix>
struct Rows {
  Matrix& matrix;
  Eigen::Index columns;
};
template <class Matrix>
Rows(Matrix&, Eigen::Index) -> Rows<Matrix>;
template <class Matrix>
struct JsonValue<Rows<Matrix>> {
  static Json write(const Rows<Matrix>& rows) {
    Json array = Json::array();
    for (Eigen::Index k = 0; k < rows.matrix.rows(); ++k)
      array.push_back(make_json(Eigen::RowVectorXd(rows.matrix.row(k))));
    return array;
  }
  static void read(const JsonNode& node, const Rows<Matrix>& rows) {
    std::vector<Eigen::RowVectorXd> all;
    for (const JsonNode& row : node.elements()) {
      read_json(row, all.emplace_back());
      if (all.back().size() != rows.columns) return row.note_error("wrong length, expected one number per input");
    }
    rows.matrix.resize(static_cast<Eigen::Index>(all.size()), rows.columns);
    for (std::size_t k = 0; k < all.size(); ++k) rows.matrix.row(static_cast<Eigen::Index>(k)) = all[k];
  }
};

}  // namespace gyrotherm

namespace gyrotherm::model {
namespace {

std::string_view form_name(const methods::Function& function) {
  constexpr std::array kForms = {"svr", "linear", "expansion", "network"};
  return kForms[function.index()];
}

/// One input with all of its values, grouped for readers of the file.
struct ModelInput {
  data::Term term;
  double mean{}, std{}, min{}, max{};
};

void describe(auto& form, Like<ModelInput> auto& input) {
  describe(form, input.term);
  form("mean", bounded_number(input.mean));
  form("std", positive_number(input.std));
  form("min", bounded_number(input.min));
  form("max", bounded_number(input.max));
  form.expect("max", input.max >= input.min, "expected no less than min");
}

std::vector<ModelInput> to_inputs(const Model& model) {
  std::vector<ModelInput> inputs;
  for (std::size_t k = 0; k < model.terms.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    inputs.push_back(
        {model.terms[k], model.scaling.mean(i), model.scaling.std(i), model.input_min(i), model.input_max(i)});
  }
  return inputs;
}

void store_inputs(const std::vector<ModelInput>& inputs, Model& model) {
  for (auto* row : {&model.scaling.mean, &model.scaling.std, &model.input_min, &model.input_max})
    row->resize(static_cast<Eigen::Index>(inputs.size()));
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    model.terms.push_back(inputs[k].term);
    model.scaling.mean(i) = inputs[k].mean;
    model.scaling.std(i) = inputs[k].std;
    model.input_min(i) = inputs[k].min;
    model.input_max(i) = inputs[k].max;
  }
}

}  // namespace

void describe_function(auto& form, Like<methods::SvrModel> auto& svr, Eigen::Index inputs) {
  form.object("parameters", [&](auto& parameters) {
    describe(parameters, svr.parameters);
    parameters("sigma", positive_number(svr.parameters.sigma));
  });
  form("b", bounded_number(svr.b));
  form("relative_gap", svr.relative_gap);
  form("kkt_violation", svr.kkt_violation);
  form("beta", svr.beta);
  form("support_vectors", Rows{svr.support_vectors, inputs});
  form.expect("beta", svr.beta.size() == svr.support_vectors.rows(), "expected one number per support vector");
}

void describe_function(auto& form, Like<methods::LinearModel> auto& linear, Eigen::Index inputs) {
  form("weights", linear.weights);
  form("b", bounded_number(linear.b));
  form.expect("weights", linear.weights.size() == inputs, "expected one number per input");
}

void describe_function(auto& form, Like<methods::ExpansionModel> auto& expansion, Eigen::Index inputs) {
  form("b", bounded_number(expansion.b));
  form("lengths", expansion.lengths);
  form("widths", expansion.widths);
  form("weights", expansion.weights);
  form("centres", Rows{expansion.centres, inputs});
  form.if_present("slope", expansion.slope.size() > 0, expansion.slope);
  form.expect("slope", expansion.slope.size() == 0 || expansion.slope.size() == inputs,
              "expected one number per input");
  form.expect("lengths", are_positive_numbers(expansion.lengths), "expected numbers from 1e-30 to 1e30");
  form.expect("lengths", expansion.lengths.size() == inputs, "expected one number per input");
  form.expect("widths", are_positive_numbers(expansion.widths), "expected numbers from 1e-30 to 1e30");
  form.expect("widths", expansion.widths.size() == expansion.centres.rows(), "expected one number per centre");
  form.expect("weights", expansion.weights.size() == expansion.centres.rows(), "expected one number per centre");
}

void describe_function(auto& form, Like<methods::NetworkModel> auto& network, Eigen::Index inputs) {
  form("b", bounded_number(network.b));
  form("out", network.out);
  form("offsets", network.offsets);
  form("weights", Rows{network.weights, inputs});
  form.expect("offsets", network.offsets.size() == network.weights.rows(), "expected one number per hidden unit");
  form.expect("out", network.out.size() == network.weights.rows(), "expected one number per hidden unit");
}

/// Describes the variance. Each row has as many numbers as there are columns.
void describe_variance(auto& form, Like<methods::PredictiveVariance> auto& variance, Eigen::Index inputs) {
  form("lengths", variance.lengths);
  form("signal", positive_number(variance.signal));
  form("noise", not_negative(variance.noise));
  form("centres", Rows{variance.centres, inputs});
  const Eigen::Index count = variance.centres.rows();
  form("posterior", Rows{variance.posterior, inputs + count});
  form("root", Rows{variance.root, count});
  form.expect("lengths", variance.lengths.size() == inputs && are_positive_numbers(variance.lengths),
              "expected one number per input, from 1e-30 to 1e30");
  form.expect("posterior", variance.posterior.rows() == inputs + count, "expected a square matrix");
  form.expect("root", variance.root.rows() == count && (variance.root.diagonal().array() > 0).all(),
              "expected a square matrix, its diagonal above 0");
}

/// Describes one of the four functions; "form" selects it.
void describe_function(auto& form, Like<methods::Function> auto& function, Eigen::Index inputs) {
  auto form_text = std::string(form_name(function));
  form("form", form_text);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(function)>>) {
    for (methods::Function empty : std::array<methods::Function, 4>{methods::SvrModel{}, methods::LinearModel{},
                                                                    methods::ExpansionModel{}, methods::NetworkModel{}})
      if (form_text == form_name(empty)) function = std::move(empty);
  }
  form.expect("form", form_text == form_name(function), "expected svr, linear, expansion or network");
  std::visit([&](auto& one) { describe_function(form, one, inputs); }, function);
}

void describe(auto& form, Like<TrainingRecord> auto& record) {
  form("run_id", record.run_id);
  form("path", record.path);
  form("profile_name", record.profile_name);
  form("simulated", record.simulated);
  form("clusters", record.clusters);
  form("from_s", record.from_s);
  form("to_s", record.to_s);
  form.if_present("unit", is_named(record.of), record.of.unit);
  form.if_present("axis", !record.of.axis.empty(), record.of.axis);
  form.if_present("identity", !record.identity.empty(), record.identity);
  form.if_present("bias_zero", !record.bias_zero.empty(), record.bias_zero);
  form.if_present("block", record.block.has_value(), record.block);
  form.if_present("rate_trace", record.rate_trace.has_value(), record.rate_trace);
}

void describe(auto& form, Like<ReducedSetSummary> auto& reduction) {
  form("vectors_before", reduction.vectors_before);
  form("vectors", reduction.vectors);
  form("bound_deg_per_h", not_negative(reduction.bound_deg_per_h));
  form("max_change_deg_per_h", not_negative(reduction.max_change_deg_per_h));
  form("rms_change_deg_per_h", not_negative(reduction.rms_change_deg_per_h));
  form("clusters", reduction.clusters);
}

void describe(auto& form, Like<Selection> auto& selection) {
  form("terms", selection.terms);
  form("threshold", selection.threshold);
  form("rank", selection.rank);
  form("fallback", selection.fallback);
  form("statement", selection.statement);
}

void describe_tuning(auto& form, Like<Model> auto& model) {
  auto& tuning = model.tuning;
  form("best", tuning.best);
  form("cross_validation_mse", tuning.cross_validation_mse);
  form("uncertified", tuning.uncertified);
  form("swarm", tuning.swarm);
  form("warnings", tuning.warnings);
  form("options", model.tuning_options);
  form.if_present("one_standard_error", tuning.one_standard_error.has_value(), tuning.one_standard_error);
}

/// Returns true if a model file may name this method: a method of this version or of version 0.1.0.
bool is_known_method(std::string_view method) {
  return method == kTypePriorMethod || method == "svr-joint" || methods::find_method(method).has_value();
}

void describe(auto& form, Like<Model> auto& model) {
  constexpr double kLongestClusterS = 86400;
  form.derived("schema", kModelSchema);
  form("program_version", model.program_version);
  form("inputs", model.inputs);
  form("method", model.method);
  form.expect("method", is_known_method(model.method), "expected a known method");
  form("quick", model.quick);
  form("cluster_length_s", positive(model.cluster_length_s, kLongestClusterS));
  auto inputs = to_inputs(model);
  form("terms", inputs);
  form.expect("terms", !inputs.empty(), "expected at least one input");
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(model)>>) store_inputs(inputs, model);
  form.object("target", [&](auto& target) {
    target("mean_deg_per_h", bounded_number(model.target_mean_deg_per_h));
    target("std_deg_per_h", positive_number(model.target_std_deg_per_h));
  });
  form("trained_on", model.trained_on);
  form.if_present("power_ons", !model.power_ons.empty(), model.power_ons);
  form("folds", model.folds);
  form("in_sample", model.in_sample);
  form("leave_cycle_out", model.leave_cycle_out);
  form("leave_cycle_out_residual_deg_per_h", model.leave_cycle_out_residual);
  form.if_present("verdict", model.verdict.has_value(), model.verdict);
  form("warnings", model.warnings);
  form("hyper_parameters", model.hyper_parameters);
  form("effective_parameters", not_negative(model.effective_parameters));
  form("particulars", model.particulars);
  form.object("function", [&](auto& function) {
    describe_function(function, model.function, static_cast<Eigen::Index>(model.terms.size()));
  });
  form.object_if_present("variance", model.variance.has_value(), [&](auto& variance) {
    if constexpr (!std::is_const_v<std::remove_reference_t<decltype(model)>>) model.variance.emplace();
    describe_variance(variance, *model.variance, static_cast<Eigen::Index>(model.terms.size()));
  });
  form.if_present("selection", !model.selection.terms.empty(), model.selection);
  form.if_present("residual_std_deg_per_h", std::isfinite(model.residual_std_deg_per_h),
                  not_negative(model.residual_std_deg_per_h));
  form.if_present("nested_leave_cycle_out", model.nested_leave_cycle_out.has_value(), model.nested_leave_cycle_out);
  form.object_if_present("tuning", model.tuning.swarm.end != svm::SwarmEnd::was_not_run,
                         [&](auto& tuning) { describe_tuning(tuning, model); });
  form.if_present("residual_noise", model.residual_noise.has_value(), model.residual_noise);
  form.expect("residual_noise", !model.residual_noise || is_within_limits(*model.residual_noise),
              "expected noise coefficients of at most 1e30 and an angle random walk of at least 1e-30");
  form.if_present("latency", model.latency.has_value(), model.latency);
  form.if_present("reduction", model.reduction.has_value(), model.reduction);
  form.if_present("uncertainty", model.uncertainty.has_value(), model.uncertainty);
  form.expect("uncertainty",
              !model.uncertainty || std::isfinite(combined(model.uncertainty->budget.rows).expanded_deg_per_h),
              "expected a budget with a finite combined uncertainty");
}

std::string to_json(const Model& model) { return gyrotherm::json_text(make_json(model), 1) + "\n"; }

Result<Model> model_from_json(std::string_view json, const std::string& file) {
  const auto root = JsonNode::parse(json, file, JsonNode::Nulls::are_errors);
  if (!root) return failure(root.error());
  const JsonNode schema = (*root)["schema"];
  if (schema.text() != kModelSchema)
    schema.note_error(fmt::format("\"{}\", expected \"{}\"", schema.text(), kModelSchema));
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  Model model;
  model.residual_std_deg_per_h = std::nan("");
  read_json(*root, model);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return model;
}

}  // namespace gyrotherm::model
