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

constexpr std::array kPolicies = {Outside::continued, Outside::refuse, Outside::extrapolate};

/// Returns the distance of a value from its range, as a fraction of the range; 0 inside and within the rounding of a
/// mean.
double excess(double value, double low, double high) {
  constexpr double kRounding = 1e-9;
  const double beyond = std::max(low - value, value - high);
  return beyond > kRounding * (high - low) ? beyond / std::max(high - low, std::numeric_limits<double>::min()) : 0;
}

/// Returns the fraction of the way from the training mean to the row that keeps each `bounding` input in its range.
double share_within(const Model& model, const Eigen::Ref<const Eigen::RowVectorXd>& row,
                    const std::vector<bool>& bounding) {
  double share = 1;
  for (Eigen::Index term = 0; term < row.size(); ++term) {
    const double low = model.input_min(term), high = model.input_max(term), mean = model.scaling.mean(term);
    if (!bounding[static_cast<std::size_t>(term)] || !(row(term) < low || row(term) > high)) continue;
    const double distance = row(term) > high ? high - mean : low - mean;
    share = std::min(share, std::max(distance / (row(term) - mean), 0.0));
  }
  return share;
}

/// Moves each of `rows` to its bounded point.
data::SampleMatrix bounded_points(const Model& model, data::SampleMatrix inputs,
                                  const std::vector<Eigen::Index>& rows) {
  const std::vector<RecomputedProduct> recomputed = recomputed_products(model.terms);
  std::vector<bool> bounding(model.terms.size(), true);
  for (const RecomputedProduct& product : recomputed) bounding[static_cast<std::size_t>(product.term)] = false;
  for (const Eigen::Index row : rows) {
    const double share = share_within(model, inputs.row(row), bounding);
    for (Eigen::Index term = 0; term < inputs.cols(); ++term) {
      const double mean = model.scaling.mean(term);
      inputs(row, term) = mean + share * (inputs(row, term) - mean);
    }
    for (const RecomputedProduct& product : recomputed) {
      double value = 1;
      for (const Eigen::Index factor : product.factors) value *= inputs(row, factor);
      inputs(row, product.term) = value;
    }
  }
  return inputs;
}

/// Returns true if the function has parts other than a plane. Only a linear function has none.
bool has_bounded_part(const methods::Function& function) {
  return !std::holds_alternative<methods::LinearModel>(function);
}

/// Predicts the bias, °/h, from scaled inputs; NaN if an input is not finite.
Eigen::VectorXd predict_scaled(const Model& model, const data::SampleMatrix& scaled,
                               const data::SampleMatrix& bounded) {
  Eigen::VectorXd f = evaluate_function(model.function, scaled, bounded);
  for (Eigen::Index k = 0; k < f.size(); ++k) {
    if (!scaled.row(k).allFinite()) f(k) = std::numeric_limits<double>::quiet_NaN();
  }
  return f.array() * model.target_std_deg_per_h + model.target_mean_deg_per_h;
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
  return predict_scaled(model, scaled, scaled);
}

Eigen::VectorXd predict(const Model& model, const RangedInputs& ranged) {
  if (ranged.bounded.size() == 0) return predict(model, ranged.inputs);
  return predict_scaled(model, apply(model.scaling, ranged.inputs), apply(model.scaling, ranged.bounded));
}

std::vector<RecomputedProduct> recomputed_products(const std::vector<data::Term>& terms) {
  std::vector<RecomputedProduct> recomputed;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (terms[i].factors.size() < 2) continue;
    RecomputedProduct product{.term = static_cast<Eigen::Index>(i)};
    for (const data::Factor& factor : terms[i].factors) {
      const auto at = std::ranges::find(terms, data::Term{{factor}});
      if (at != terms.end()) product.factors.push_back(at - terms.begin());
    }
    if (product.factors.size() == terms[i].factors.size()) recomputed.push_back(std::move(product));
  }
  return recomputed;
}

std::optional<BlockRange> trained_block(const std::vector<TrainingRecord>& records) {
  std::optional<BlockRange> all;
  for (const TrainingRecord& record : records) {
    if (!record.block) continue;
    if (!all) {
      all = record.block;
      continue;
    }
    all->low_c = std::min(all->low_c, record.block->low_c);
    all->high_c = std::max(all->high_c, record.block->high_c);
    for (const std::string& name : record.block->thermometers)
      if (std::ranges::find(all->thermometers, name) == all->thermometers.end()) all->thermometers.push_back(name);
    for (const ThermometerRange& other : record.block->others) {
      const auto known = std::ranges::find(all->others, other.thermometer, &ThermometerRange::thermometer);
      if (known == all->others.end()) {
        all->others.push_back(other);
      } else {
        known->low_c = std::min(known->low_c, other.low_c);
        known->high_c = std::max(known->high_c, other.high_c);
      }
    }
  }
  return all;
}

std::string describe(const BlockRange& range) {
  const auto whole = [](double value) { return fmt::format("{}{:.0f}", value < 0 ? "−" : "", std::abs(value)); };
  const auto span = [&](double low, double high) {
    return fmt::format("{} to {} °C", whole(std::ceil(low)), whole(std::floor(high)));
  };
  std::string text = "block " + span(range.low_c, range.high_c);
  if (!range.thermometers.empty()) text += fmt::format(" ({})", fmt::join(range.thermometers, ", "));
  for (const ThermometerRange& other : range.others)
    text += fmt::format(", {} {}", other.thermometer, span(other.low_c, other.high_c));
  return text;
}

const TrainingRecord* find_other_gyro(const Model& model, std::string_view identity) {
  const auto found = std::ranges::find_if_not(model.trained_on, [&](const TrainingRecord& record) {
    return data::may_be_same_gyro(record.identity, identity);
  });
  return found == model.trained_on.end() ? nullptr : &*found;
}

const TrainingRecord* find_other_axis(const Model& model, const data::AxisChoice& of) {
  const auto found = std::ranges::find_if(model.trained_on, [&](const TrainingRecord& record) {
    const bool both_named = !record.of.axis.empty() && !of.axis.empty();
    return both_named && record.of.unit == of.unit && record.of.axis != of.axis;
  });
  return found == model.trained_on.end() ? nullptr : &*found;
}

Origin find_origin(const data::Dataset& dataset) {
  return {.of = dataset.of, .identity = dataset.identity, .bias_zero = dataset.bias_zero, .run_id = dataset.run_id};
}

namespace {

/// Returns true if the zero of a training record differs from that of the biases.
bool has_other_zero(const TrainingRecord& record, const Origin& origin) {
  if (record.bias_zero.empty() || origin.bias_zero.empty()) return false;
  const bool is_same_record = record.run_id == origin.run_id && record.bias_zero == origin.bias_zero;
  return !is_same_record && !data::have_same_zero(record.bias_zero, origin.bias_zero);
}

}  // namespace

std::vector<std::string> origin_warnings(const Model& model, const Origin& origin) {
  std::vector<std::string> warnings;
  if (const auto* other = find_other_gyro(model, origin.identity))
    warnings.push_back(fmt::format("the model belongs to another gyro: it was trained on {}, this record is of {}",
                                   other->identity, origin.identity));
  if (const auto* other = find_other_axis(model, origin.of))
    warnings.push_back(fmt::format("the model belongs to another axis: it was trained on {}, this is {}",
                                   qualified_name(other->of), qualified_name(origin.of)));
  const auto other = std::ranges::find_if(model.trained_on,
                                          [&](const TrainingRecord& record) { return has_other_zero(record, origin); });
  if (other == model.trained_on.end()) return warnings;
  const bool is_own_mean = other->bias_zero == origin.bias_zero;
  warnings.push_back(
      is_own_mean
          ? fmt::format("the bias reference of the model and that of this record are means of different "
                        "records ({}): the residual contains the unknown difference of the two references",
                        origin.bias_zero)
          : fmt::format("the model was trained with the bias reference \"{}\", but this record uses \"{}\": the "
                        "constant difference of the two references remains in the residual",
                        other->bias_zero, origin.bias_zero));
  return warnings;
}

Result<Prediction> predict_with_std(const Model& model, const data::SampleMatrix& inputs) {
  if (!model.variance) {
    return failure(FaultKind::usage, "standard deviation", fmt::format("method {} does not estimate it", model.method));
  }
  const Eigen::VectorXd variance = evaluate_variance(*model.variance, apply(model.scaling, inputs));
  return Prediction{predict(model, inputs), model.target_std_deg_per_h * variance.cwiseSqrt()};
}

int stored_numbers(const Model& model) {
  const auto inputs = static_cast<int>(model.terms.size());
  constexpr int kPerInput = 2, kOfTarget = 2;  // mean and STD each
  return count_stored_numbers(model.function) + kPerInput * inputs + kOfTarget;
}

const char* name(Outside outside) {
  constexpr const char* kNames[] = {"continue", "refuse", "extrapolate"};
  return kNames[static_cast<std::size_t>(outside)];
}

Result<Outside> parse_outside(std::string_view text) {
  const auto* found = std::ranges::find_if(kPolicies, [&](Outside policy) { return text == name(policy); });
  if (found != kPolicies.end()) return *found;
  return failure(FaultKind::usage, "--outside",
                 fmt::format("\"{}\" is not a policy, expected continue, refuse or extrapolate", text));
}

RangedInputs apply_range_policy(const Model& model, data::SampleMatrix inputs, Outside outside) {
  assert(inputs.cols() == model.input_min.size() && inputs.cols() == model.input_max.size());
  RangedInputs ranged;
  ranged.excess = Eigen::VectorXd::Zero(inputs.rows());
  for (Eigen::Index row = 0; row < inputs.rows(); ++row) {
    if (!inputs.row(row).allFinite()) continue;
    for (Eigen::Index term = 0; term < inputs.cols(); ++term) {
      const double by = excess(inputs(row, term), model.input_min(term), model.input_max(term));
      ranged.excess(row) = std::max(ranged.excess(row), by);
      if (by <= ranged.worst_excess) continue;
      ranged.worst_excess = by;
      ranged.worst_term = term;
    }
    if (ranged.excess(row) == 0) continue;
    ranged.rows.push_back(row);
    if (outside == Outside::refuse) inputs.row(row).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  if (outside == Outside::continued && !ranged.rows.empty() && has_bounded_part(model.function))
    ranged.bounded = bounded_points(model, inputs, ranged.rows);
  ranged.inputs = std::move(inputs);
  return ranged;
}

}  // namespace gyrotherm::model
