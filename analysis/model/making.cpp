// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/making.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "analysis/data/hold_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/stream.hpp"

namespace gyrotherm::model {
namespace {

/// Returns the thermometers in the terms of a model, also those of which it uses only the rate.
std::set<std::string> thermometers_in(const std::vector<data::Term>& terms) {
  std::set<std::string> names;
  for (const data::Term& term : terms)
    for (const data::Factor& factor : term.factors) names.insert({factor.first, factor.second});
  return names;
}

/// Returns the lowest and the highest value of a column; nothing if it has none.
std::optional<std::pair<double, double>> find_span(const Eigen::VectorXd& values) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto finite = values.array().isFinite();
  if (!finite.any()) return std::nullopt;
  return std::pair(finite.select(values.array(), kNone).minCoeff(), finite.select(values.array(), -kNone).maxCoeff());
}

/// Returns the range of the block's thermometers, and that of each other temperature among the inputs of a model.
std::optional<BlockRange> find_block_range(const data::Dataset& dataset, const data::Clusters& clusters,
                                           const std::set<std::string>& inputs) {
  const std::vector<std::string> block = data::block_thermometers(dataset);
  std::optional<BlockRange> range;
  std::vector<ThermometerRange> others;
  for (std::size_t i = 0; i < clusters.thermometers.size(); ++i) {
    const std::string& name = clusters.thermometers[i];
    const auto span = find_span(clusters.temperature_c.col(static_cast<Eigen::Index>(i)));
    if (!span || !data::is_temperature(name)) continue;
    if (std::ranges::find(block, name) == block.end()) {
      if (inputs.contains(name)) others.push_back({name, span->first, span->second});
      continue;
    }
    if (!range) range = BlockRange{span->first, span->second};
    range->low_c = std::min(range->low_c, span->first);
    range->high_c = std::max(range->high_c, span->second);
    range->thermometers.push_back(name);
  }
  if (range) range->others = std::move(others);
  return range;
}

/// Returns the span of the clusters: start of the first and end of the last; 0 to 0 if there are none.
std::pair<double, double> find_period(const data::Clusters& clusters) {
  const Eigen::Index count = clusters.start_s.size();
  if (count == 0) return {0, 0};
  return {clusters.start_s(0), clusters.start_s(count - 1) + clusters.length_s};
}

/// Returns the trace by which an export of the record is recognised. Virtual runs with one seed have the same noise,
/// so a simulated record has a trace only if it was imported.
std::optional<data::RateTrace> make_trace(const data::Dataset& dataset, double from_s, double to_s) {
  if (!dataset.imported && dataset.simulated) return std::nullopt;
  auto trace = data::trace_rates(dataset, from_s, to_s);
  return trace.means.empty() ? std::nullopt : std::optional(std::move(trace));
}

tl::unexpected<Fault> common_rows_fault(const std::string& path, const std::string& other) {
  return failure(FaultKind::usage, path, fmt::format("has rows of {}; expected records without common rows", other));
}

}  // namespace

ReadingsSample sample_readings(const data::Dataset& dataset, const data::Clusters& clusters) {
  if (!dataset.imported) return {.path = dataset.path, .trace = {}};
  const auto [from_s, to_s] = find_period(clusters);
  return {.path = dataset.path, .trace = make_trace(dataset, from_s, to_s)};
}

bool has_readings_of(const data::Dataset& dataset, const data::Clusters& clusters, const ReadingsSample& sample) {
  if (!dataset.imported || !sample.trace) return false;
  const auto [from_s, to_s] = find_period(clusters);
  return data::has_rates_of(dataset, *sample.trace, from_s, to_s);
}

Result<void> check_distinct(const data::Dataset& dataset, const data::Clusters& clusters,
                            const std::vector<ReadingsSample>& others) {
  for (const ReadingsSample& other : others)
    if (has_readings_of(dataset, clusters, other)) return common_rows_fault(dataset.path, other.path);
  return {};
}

Result<void> check_records(const std::vector<data::Dataset>& datasets, const std::vector<data::Clusters>& records) {
  std::vector<ReadingsSample> sampled;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    sampled.push_back(sample_readings(datasets[i], records[i]));
    if (jumps_by_turning(datasets[i], records[i]))
      return failure(FaultKind::usage, datasets[i].path,
                     "the unit is turned around in this record, and the Earth rate is unknown: the bias has a step of "
                     "twice the Earth rate");
    for (std::size_t j = 0; j < i; ++j) {
      const data::Dataset &one = datasets[i], &other = datasets[j];
      if (one.run_id == other.run_id)
        return failure(FaultKind::usage, one.path, fmt::format("is the same run as {}", other.path));
      // A short file that is a part of a long one is found by its own sample.
      if (has_readings_of(one, records[i], sampled[j]) || has_readings_of(other, records[j], sampled[i]))
        return common_rows_fault(one.path, other.path);
      if (auto one_gyro = check_same_gyro(one, other, other.path, "; all records of a model must be of one gyro");
          !one_gyro)
        return one_gyro;
      if (auto one_zero = check_same_reference(one, other.bias_zero, other.path); !one_zero) return one_zero;
    }
  }
  return {};
}

void record_sources(Model& model, const std::vector<data::Dataset>& datasets,
                    const std::vector<data::Clusters>& records) {
  const std::set<std::string> inputs = thermometers_in(model.terms);
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const data::Dataset& dataset = datasets[i];
    const Eigen::Index count = records[i].start_s.size();
    if (count == 0) continue;
    const auto [from_s, to_s] = find_period(records[i]);
    model.trained_on.push_back({dataset.run_id, dataset.path, dataset.profile_name, dataset.simulated,
                                static_cast<int>(count), from_s, to_s, dataset.of, dataset.identity, dataset.bias_zero,
                                find_block_range(dataset, records[i], inputs), make_trace(dataset, from_s, to_s)});
    const bool is_three_point = model.inputs.find("three-point") != std::string::npos;
    if (dataset.three_point_stand_in && is_three_point) {
      model.warnings.push_back(
          fmt::format("{}: no shell thermometer; {} is used instead", dataset.path, dataset.three_point.back()));
    }
  }
}

Result<void> evaluate_in_sample(Model& model, const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  model.input_min = inputs->colwise().minCoeff();
  model.input_max = inputs->colwise().maxCoeff();
  const Eigen::VectorXd predicted = predict(model, *inputs);
  model.latency = measure_latency(model, clusters, predicted);
  const Eigen::VectorXd residual = clusters.bias_deg_per_h - predicted;
  model.in_sample = compute_figures(residual, clusters);
  const double freedom = static_cast<double>(residual.size()) - model.effective_parameters;
  model.residual_std_deg_per_h = freedom > 0 ? std::sqrt(residual.squaredNorm() / freedom) : std::nan("");
  return {};
}

void warn_about_over_fit(Model& model, const std::vector<data::Dataset>& datasets,
                         const std::vector<data::Clusters>& records) {
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const data::NoiseFloor floor = noise_floor(records[i], datasets[i]);
    if (const auto warning = over_fit_warning(model.in_sample, floor, model.effective_parameters)) {
      const std::string record = std::filesystem::path(datasets[i].path).filename().string();
      model.warnings.push_back(fmt::format("in-sample, against {}: {}", record, *warning));
    }
  }
}

std::optional<tracking::BiasNoise> held_out_noise(const Model& model, const std::vector<data::Dataset>& datasets,
                                                  const std::vector<data::Clusters>& records,
                                                  const data::Clusters& all) {
  double floor_deg_per_h = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < datasets.size() && std::isnan(floor_deg_per_h); ++i)
    floor_deg_per_h = noise_floor(records[i], datasets[i]).deg_per_h;
  const auto noise = tracking::estimate_bias_noise(model.leave_cycle_out_residual, all, floor_deg_per_h);
  return noise ? std::optional(*noise) : std::nullopt;
}

}  // namespace gyrotherm::model
