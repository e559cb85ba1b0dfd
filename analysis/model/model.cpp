// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrotherm::model {
namespace {

constexpr std::array kPolicies = {Outside::clamp, Outside::refuse, Outside::extrapolate};

/// How far a value lies outside, as a part of the range; 0 inside, and for what the rounding of a mean may amount to.
double excess(double value, double low, double high) {
  constexpr double kRounding = 1e-9;
  const double beyond = std::max(low - value, value - high);
  return beyond > kRounding * (high - low) ? beyond / std::max(high - low, std::numeric_limits<double>::min()) : 0;
}

}  // namespace

Result<Eigen::VectorXd> predict(const Model& model, const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  return predict(model, *inputs);
}

int rows_in_cluster(const Model& model) {
  return static_cast<int>(std::max(1LL, std::llround(model.cluster_length_s)));
}

Eigen::VectorXd predict(const Model& model, const data::SampleMatrix& inputs) {
  assert(inputs.cols() == static_cast<Eigen::Index>(model.terms.size()));
  const data::SampleMatrix scaled = apply(model.scaling, inputs);
  Eigen::VectorXd f = value_of(model.function, scaled);
  for (Eigen::Index k = 0; k < f.size(); ++k) {
    if (!inputs.row(k).allFinite()) f(k) = std::numeric_limits<double>::quiet_NaN();
  }
  return f.array() * model.target_std_deg_per_h + model.target_mean_deg_per_h;
}

const TrainingRecord* trained_on_another(const Model& model, std::string_view identity) {
  const auto found = std::ranges::find_if_not(
      model.trained_on, [&](const TrainingRecord& record) { return data::may_be_one_gyro(record.identity, identity); });
  return found == model.trained_on.end() ? nullptr : &*found;
}

const TrainingRecord* trained_on_another_axis(const Model& model, const data::AxisChoice& of) {
  const auto found = std::ranges::find_if(model.trained_on, [&](const TrainingRecord& record) {
    const bool both_say_it = !record.of.axis.empty() && !of.axis.empty();
    return both_say_it && record.of.unit == of.unit && record.of.axis != of.axis;
  });
  return found == model.trained_on.end() ? nullptr : &*found;
}

std::vector<std::string> warnings_of_origin(const Model& model, const data::AxisChoice& of, std::string_view identity,
                                            std::string_view bias_zero) {
  std::vector<std::string> warnings;
  if (const auto* other = trained_on_another(model, identity))
    warnings.push_back(fmt::format("the model is of another gyro: it was trained on {}, this record is of {}",
                                   other->identity, identity));
  if (const auto* other = trained_on_another_axis(model, of))
    warnings.push_back(fmt::format("the model is of another axis: it was trained on {}, this is {}",
                                   in_words(other->of), in_words(of)));
  const auto has_another_zero = [&](const TrainingRecord& record) {
    return !record.bias_zero.empty() && !bias_zero.empty() && record.bias_zero != bias_zero;
  };
  if (const auto other = std::ranges::find_if(model.trained_on, has_another_zero); other != model.trained_on.end())
    warnings.push_back(
        fmt::format("the model was trained on a bias that is counted from another zero ({}) than this "
                    "record's ({}): the constant between the two is left",
                    other->bias_zero, bias_zero));
  return warnings;
}

Result<Prediction> predict_with_std(const Model& model, const data::SampleMatrix& inputs) {
  if (!model.variance) {
    return failure(FaultKind::usage, "standard deviation", fmt::format("a model of {} does not know it", model.method));
  }
  const Eigen::VectorXd variance = variance_of(*model.variance, apply(model.scaling, inputs));
  return Prediction{predict(model, inputs), model.target_std_deg_per_h * variance.cwiseSqrt()};
}

int stored_numbers(const Model& model) {
  const auto inputs = static_cast<int>(model.terms.size());
  constexpr int kPerInput = 2, kOfTarget = 2;  // mean and STD each
  return numbers_in(model.function) + kPerInput * inputs + kOfTarget;
}

const char* name(Outside outside) {
  constexpr const char* kNames[] = {"clamp", "refuse", "extrapolate"};
  return kNames[static_cast<std::size_t>(outside)];
}

Result<Outside> parse_outside(std::string_view text) {
  const auto* found = std::ranges::find_if(kPolicies, [&](Outside policy) { return text == name(policy); });
  if (found != kPolicies.end()) return *found;
  return failure(FaultKind::usage, "--outside",
                 fmt::format("\"{}\" is no policy, expected clamp, refuse or extrapolate", text));
}

RangedInputs within_range(const Model& model, data::SampleMatrix inputs, Outside outside) {
  assert(inputs.cols() == model.input_min.size() && inputs.cols() == model.input_max.size());
  RangedInputs ranged;
  for (Eigen::Index row = 0; row < inputs.rows(); ++row) {
    if (!inputs.row(row).allFinite()) continue;
    bool is_outside = false;
    for (Eigen::Index term = 0; term < inputs.cols(); ++term) {
      const double by = excess(inputs(row, term), model.input_min(term), model.input_max(term));
      is_outside = is_outside || by > 0;
      if (by <= ranged.worst_excess) continue;
      ranged.worst_excess = by;
      ranged.worst_term = term;
    }
    if (!is_outside) continue;
    ranged.rows.push_back(row);
    if (outside == Outside::refuse) inputs.row(row).setConstant(std::numeric_limits<double>::quiet_NaN());
    if (outside == Outside::clamp) {
      inputs.row(row) = inputs.row(row).cwiseMax(model.input_min).cwiseMin(model.input_max).eval();
    }
  }
  ranged.inputs = std::move(inputs);
  return ranged;
}

}  // namespace gyrotherm::model
