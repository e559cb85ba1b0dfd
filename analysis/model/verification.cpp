// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/verification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "analysis/data/distributions.hpp"
#include "analysis/model/making.hpp"
#include "analysis/model/stream.hpp"
#include "analysis/model/uncertainty.hpp"
#include "core/number_text.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kCornerSeconds = 600;
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

using Rows = std::vector<Eigen::Index>;

template <class Predicate>
Rows select_rows(const data::Clusters& clusters, Predicate selects) {
  Rows rows;
  for (Eigen::Index k = 0; k < clusters.start_s.size(); ++k) {
    if (selects(k)) rows.push_back(k);
  }
  return rows;
}

/// Computes the figures of the rows that have a residual.
data::Figures figures_at(const Eigen::VectorXd& residual, const data::Clusters& clusters, Rows rows) {
  std::erase_if(rows, [&](Eigen::Index k) { return !std::isfinite(residual(k)); });
  return compute_figures(residual(rows), clusters, rows);
}

/// Start and end of a segment's samples; start > end if it has none.
struct Stretch {
  double start_s = std::numeric_limits<double>::infinity();
  double end_s = -std::numeric_limits<double>::infinity();
};

std::vector<Stretch> find_stretches(const data::Dataset& dataset) {
  constexpr double kSampleSeconds = 1;
  std::vector<Stretch> stretches(dataset.segments.size());
  for (Eigen::Index i = 0; i < dataset.segment.size(); ++i) {
    if (dataset.segment(i) < 0) continue;
    Stretch& stretch = stretches[dataset.segment(i)];
    stretch.start_s = std::min(stretch.start_s, dataset.time_s(i));
    stretch.end_s = std::max(stretch.end_s, dataset.time_s(i) + kSampleSeconds);
  }
  return stretches;
}

/// Returns the times at which the requested rate of change changes: each segment's start except the first, and except a
/// hold that follows a hold at the same temperature.
std::vector<double> find_corners(const data::Dataset& dataset, const std::vector<Stretch>& stretches) {
  std::vector<double> corners;
  for (std::size_t s = 1; s < stretches.size(); ++s) {
    const auto &before = dataset.segments[s - 1], &after = dataset.segments[s];
    const bool continues = before.hold && after.hold && before.target == after.target;
    const bool recorded =
        stretches[s].start_s < stretches[s].end_s && stretches[s - 1].start_s < stretches[s - 1].end_s;
    if (recorded && !continues) corners.push_back(stretches[s].start_s);
  }
  return corners;
}

Rows find_corner_rows(const std::vector<double>& corners, const data::Clusters& clusters) {
  return select_rows(clusters, [&](Eigen::Index k) {
    return std::ranges::any_of(corners, [&](double corner_s) {
      return clusters.start_s(k) < corner_s + kCornerSeconds && clusters.start_s(k) + clusters.length_s > corner_s;
    });
  });
}

std::vector<SegmentFigures> segment_figures(const data::Dataset& dataset, const data::Clusters& clusters,
                                            const Eigen::VectorXd& residual, const std::vector<Stretch>& stretches) {
  std::vector<SegmentFigures> figures;
  for (std::size_t s = 0; s < dataset.segments.size(); ++s) {
    const auto segment = static_cast<int>(s);
    const Rows rows = select_rows(clusters, [&](Eigen::Index k) { return clusters.segment(k) == segment; });
    if (rows.empty()) continue;
    figures.push_back({.segment = segment,
                       .name = dataset.segments[s].name,
                       .hold = dataset.segments[s].hold,
                       .start_s = stretches[s].start_s,
                       .duration_s = stretches[s].end_s - stretches[s].start_s,
                       .mean_temperature_c = clusters.temperature_c.col(0)(rows).mean(),
                       .mean_bias_deg_per_h = clusters.bias_deg_per_h(rows).mean(),
                       .residual = figures_at(residual, clusters, rows)});
  }
  return figures;
}

RangeExceedance summarise_outside(const Model& model, const RangedInputs& ranged, Outside policy) {
  RangeExceedance outside{.policy = policy, .clusters = static_cast<int>(ranged.rows.size()), .farthest_term = {}};
  if (ranged.worst_term < 0) return outside;
  outside.farthest_term = to_string(model.terms[static_cast<std::size_t>(ranged.worst_term)]);
  outside.farthest = ranged.worst_excess;
  return outside;
}

const char* describe_policy(Outside policy) {
  constexpr const char* kDescriptions[] = {
      "the plane is extrapolated, the other parts are evaluated at the range limit, and U is larger",
      "these clusters are not compensated and are excluded from the results", "the whole model is extrapolated"};
  return kDescriptions[static_cast<std::size_t>(policy)];
}

/// Returns the reason why no cluster is compensated. `known` is the number of clusters with all inputs; `outside`
/// counts those of them with an input outside the trained range.
const char* no_result_reason(std::size_t known, std::size_t outside) {
  if (known == 0) return "no cluster has all inputs of the model (a rate needs the previous cluster)";
  if (outside == known)
    return "every cluster with all inputs has an input outside the trained range, which the policy refuses";
  return "the model predicts no finite bias";
}

/// Returns true if the model was trained on any of these clusters: the same axis of the same run, in an overlapping
/// period.
bool is_trained_on(const Model& model, const data::Dataset& dataset, const data::Clusters& clusters) {
  const double from_s = clusters.start_s(0), to_s = clusters.start_s(clusters.start_s.size() - 1) + clusters.length_s;
  return std::ranges::any_of(model.trained_on, [&](const TrainingRecord& record) {
    const bool same_axis = record.of == dataset.of || record.of == data::AxisChoice{};
    return record.run_id == dataset.run_id && same_axis && from_s < record.to_s && record.from_s < to_s;
  });
}

/// Returns true if rows of these clusters are also in a training record, in whatever file and at whatever time.
bool has_training_rows(const Model& model, const data::Dataset& dataset, const data::Clusters& clusters) {
  return std::ranges::any_of(model.trained_on, [&](const TrainingRecord& record) {
    return has_readings_of(dataset, clusters, {.path = {}, .trace = record.rate_trace});
  });
}

/// Returns the model's effective parameters times the ratio of verified clusters to training clusters; 0 if the model
/// was not trained on this record.
double share_of_parameters(const Model& model, const Verification& result) {
  if (!result.trained_on_this) return 0;
  int all = 0;
  for (const TrainingRecord& record : model.trained_on) all += record.clusters;
  return all > 0 && model.effective_parameters > 0 ? model.effective_parameters * result.compensated.count / all : 0;
}

/// Judges the gain on the clusters with a residual, and the intervals. Without a coverage the intervals have no
/// verdict.
Verdict judge(const Verification& result, const data::Clusters& clusters) {
  constexpr int kFewest = 8;
  const Rows rows = data::finite_rows(result.residual_deg_per_h);
  const BiasZero zero = result.has_own_reference ? BiasZero::mean_of_first_hold : BiasZero::known;
  Verdict verdict =
      judge_gain(clusters.bias_deg_per_h(rows), result.residual_deg_per_h(rows), clusters, rows, zero, kFewest);
  if (result.trained_on_this) {
    verdict.gain = Gain::in_sample;
    verdict.only_offset = false;
    verdict.statement = "the model was trained on this record, so the record cannot verify it";
  } else if (result.coverage) {
    const Coverage& coverage = *result.coverage;
    verdict.intervals_hold = !is_below_nominal(coverage.seen, coverage.nominal, coverage.effective);
  }
  return verdict;
}

std::vector<std::string> make_warnings(const Verification& result, const Model& model, const data::Dataset& dataset,
                                       const data::Clusters& clusters) {
  std::vector<std::string> warnings;
  if (dataset.has_own_reference)
    warnings.push_back(fmt::format(
        "the bias reference is computed from this record, {}, so the zero of the bias is unknown: mean, RMSE and "
        "maximum of the residual contain an unknown constant; only the STD does not depend on it{}",
        dataset.bias_zero, model.uncertainty ? "; the intervals are not judged" : ""));
  if (dataset.stopped_in)
    warnings.push_back(
        fmt::format("the run was stopped in segment {} of {}: results over the whole run cover its part until then",
                    *dataset.stopped_in + 1, dataset.segments.size()));
  if (jumps_by_turning(dataset, clusters)) {
    warnings.push_back(
        "the unit is turned around and the Earth rate is unknown: results over both positions contain a step of twice "
        "the Earth rate");
  }
  if (result.has_training_rows) {
    warnings.push_back(
        "the model was trained on rows of this record, which are in another file: the results are in-sample and not a "
        "verification");
  } else if (result.trained_on_this) {
    const bool is_virtual = dataset.simulated && !dataset.imported;
    warnings.emplace_back(is_virtual ? kTrainedOnThisVirtualRunWarning : kTrainedOnThisWarning);
  } else if (auto warning = make_no_gain_warning("compensated bias", result.verdict)) {
    warnings.push_back(std::move(*warning));
  }
  if (result.verdict.intervals_hold == false)
    warnings.push_back(
        fmt::format("the intervals do not hold: {:.1f} % of {} means lie within their {:.0f} % intervals",
                    100 * result.coverage->seen, result.coverage->clusters, 100 * result.coverage->nominal));
  std::ranges::move(origin_warnings(model, find_origin(dataset)), std::back_inserter(warnings));
  if (auto warning = over_fit_warning(result.compensated, result.floor, share_of_parameters(model, result)))
    warnings.push_back(*warning);
  if (const RangeExceedance& outside = result.outside; outside.clusters > 0) {
    const auto block = trained_block(model.trained_on);
    warnings.push_back(fmt::format(
        "{} of {} clusters {} an input outside the trained range{} (farthest: {}, by {} % of its range); {}",
        outside.clusters, clusters.start_s.size(), outside.clusters == 1 ? "has" : "have",
        block ? ", " + describe(*block) : "", outside.farthest_term, format_digits(100 * outside.farthest, 2),
        describe_policy(outside.policy)));
  }
  if (clusters.length_s != model.cluster_length_s) {
    warnings.push_back(fmt::format("the model was trained on means over {} s, but the clusters are means over {} s",
                                   model.cluster_length_s, clusters.length_s));
  }
  return warnings;
}

/// Returns the cluster means of the streamed compensated bias, °/h; NaN if a second of the cluster has no value.
Eigen::VectorXd streamed_means(const Eigen::VectorXd& compensated, const data::Dataset& dataset,
                               const data::Clusters& clusters) {
  Eigen::VectorXd means = Eigen::VectorXd::Constant(clusters.start_s.size(), kMissing);
  Eigen::Index row = 0;
  for (Eigen::Index k = 0; k < means.size(); ++k) {
    const double start = clusters.start_s(k), end = start + clusters.length_s;
    while (row < compensated.size() && dataset.time_s(row) < start) ++row;
    double sum = 0, count = 0;
    for (; row < compensated.size() && dataset.time_s(row) < end; ++row, ++count) sum += compensated(row);
    if (count > 0) means(k) = sum / count;
  }
  return means;
}

/// Returns 1 inside the interval and 0 outside; NaN without a residual or an interval.
Eigen::VectorXd coverage_flags(const Eigen::VectorXd& residual, const Eigen::VectorXd& half_width) {
  return residual.binaryExpr(half_width, [](double value, double half) {
    if (!std::isfinite(value) || !std::isfinite(half)) return kMissing;
    return std::abs(value) <= half ? 1.0 : 0.0;
  });
}

std::optional<Coverage> find_coverage(const Eigen::VectorXd& residual, const Eigen::VectorXd& half_width,
                                      const data::Clusters& clusters) {
  const Eigen::VectorXd within = coverage_flags(residual, half_width);
  const Rows rows = data::finite_rows(within);
  if (rows.empty()) return std::nullopt;
  const data::Figures share = compute_figures(within(rows), clusters, rows);
  return Coverage{.nominal = kCoverage,
                  .seen = share.mean,
                  .clusters = share.count,
                  .effective = share.effective.of_mean,
                  .mean_half_width_deg_per_h = half_width(rows).mean()};
}

}  // namespace

std::optional<TrueBiasError> compute_true_bias_error(const data::Dataset& dataset, const data::Clusters& clusters,
                                                     const Eigen::VectorXd& residual) {
  if (clusters.true_bias_deg_per_h.size() == 0) return {};
  Eigen::VectorXd error = clusters.bias_deg_per_h - residual - clusters.true_bias_deg_per_h;
  const Rows rows = select_rows(clusters, [&](Eigen::Index k) { return std::isfinite(error(k)); });
  if (rows.empty()) return {};
  TrueBiasError result{.figures = {}, .mean_removed = dataset.has_own_reference};
  if (result.mean_removed) error.array() -= error(rows).mean();
  result.figures = compute_figures(error(rows), clusters, rows);
  return result;
}

Result<Verification> verify(const Model& model, const data::Dataset& dataset, const data::Clusters& clusters,
                            Outside outside) {
  auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const std::size_t known = data::finite_rows(*inputs).size();
  const RangedInputs ranged = apply_range_policy(model, std::move(*inputs), outside);
  const Eigen::VectorXd residual = clusters.bias_deg_per_h - predict(model, ranged);
  const std::vector<Stretch> stretches = find_stretches(dataset);
  const auto figures_where = [&](auto selects) {
    return figures_at(residual, clusters, select_rows(clusters, selects));
  };
  const auto part = [&](bool hold) {
    return figures_where([&, hold](Eigen::Index k) {
      return clusters.segment(k) >= 0 && dataset.segments[clusters.segment(k)].hold == hold;
    });
  };
  Verification result;
  result.run_id = dataset.run_id;
  result.identity = dataset.identity;
  result.simulated = dataset.simulated;
  const bool is_of_same_run = is_trained_on(model, dataset, clusters);
  result.has_training_rows = !is_of_same_run && has_training_rows(model, dataset, clusters);
  result.trained_on_this = is_of_same_run || result.has_training_rows;
  result.bias_zero = dataset.bias_zero;
  result.has_own_reference = dataset.has_own_reference;
  const Rows compared = data::finite_rows(residual);
  result.raw = compute_figures(clusters.bias_deg_per_h(compared), clusters, compared);
  result.compensated = compute_figures(residual(compared), clusters, compared);
  if (result.compensated.count == 0) {
    return failure(FaultKind::usage, dataset.path, no_result_reason(known, ranged.rows.size()));
  }
  result.ramps = part(false);
  result.holds = part(true);
  result.corners = figures_at(residual, clusters, find_corner_rows(find_corners(dataset, stretches), clusters));
  result.to_truth = compute_true_bias_error(dataset, clusters, residual);
  result.floor = noise_floor(clusters, dataset);
  result.effective_parameters = model.effective_parameters > 0 ? model.effective_parameters : 0;
  result.expected_in_sample_std =
      expected_in_sample_std(result.floor, share_of_parameters(model, result), result.compensated.count);
  result.residual_deg_per_h = residual;
  result.segments = segment_figures(dataset, clusters, residual, stretches);
  result.outside = summarise_outside(model, ranged, outside);
  if (model.uncertainty && !dataset.has_own_reference) {
    const auto half_width = interval_half_widths(model, *model.uncertainty, dataset, clusters);
    if (!half_width) return failure(half_width.error());
    result.coverage = find_coverage(residual, *half_width, clusters);
    if (result.coverage)
      result.coverage->effective = std::min(result.coverage->effective, result.compensated.effective.of_mean);
  }
  result.verdict = judge(result, clusters);
  result.warnings = make_warnings(result, model, dataset, clusters);
  return result;
}

Result<StreamResult> evaluate_stream(const Model& model, const data::Dataset& dataset, const data::Clusters& clusters,
                                     const Eigen::VectorXd& aligned_residual_deg_per_h, Outside outside) {
  constexpr double kGreatestIntervalError = 0.01;
  if (std::abs(data::sample_interval_s(dataset) - 1) > kGreatestIntervalError)
    return failure(FaultKind::usage, dataset.path,
                   "the rows are not at intervals of one second, which streaming requires");
  auto stream = CompensationStream::open(model, dataset.thermometers, outside);
  if (!stream) return failure(stream.error());
  const data::SampleMatrix temperatures = dataset.temperature_c;
  Eigen::VectorXd residual =
      streamed_means(stream->push_at(dataset.time_s, temperatures, dataset.bias_deg_per_h), dataset, clusters);
  Eigen::VectorXd aligned = aligned_residual_deg_per_h;
  for (Eigen::Index k = 0; k < residual.size(); ++k)
    if (!std::isfinite(residual(k)) || !std::isfinite(aligned(k))) residual(k) = aligned(k) = kMissing;
  const std::vector<Eigen::Index> rows = data::finite_rows(residual);
  if (rows.empty()) return failure(FaultKind::usage, dataset.path, "no cluster has a streamed value in every second");
  return StreamResult{.residual = compute_figures(residual(rows), clusters, rows),
                      .aligned = compute_figures(aligned(rows), clusters, rows),
                      .to_truth = compute_true_bias_error(dataset, clusters, residual),
                      .aligned_to_truth = compute_true_bias_error(dataset, clusters, aligned)};
}

std::optional<RunScatter> compute_run_scatter(const std::vector<Verification>& verifications) {
  std::set<std::string> seen, zeros, gyros;
  std::vector<double> means;
  for (const Verification& one : verifications) {
    if (one.trained_on_this || one.has_own_reference || !seen.insert(one.run_id).second) continue;
    means.push_back(one.compensated.mean);
    zeros.insert(one.bias_zero);
    if (!one.identity.empty()) gyros.insert(one.identity);
  }
  if (means.size() < 2 || zeros.size() > 1 || gyros.size() > 1) return std::nullopt;
  const data::Figures figures =
      data::compute_figures(Eigen::Map<const Eigen::VectorXd>(means.data(), static_cast<Eigen::Index>(means.size())));
  const int freedom = figures.count - 1;
  return RunScatter{.runs = figures.count,
                    .mean_deg_per_h = figures.mean,
                    .std_deg_per_h = figures.std,
                    .degrees_of_freedom = freedom,
                    .expanded_deg_per_h = figures.std * data::coverage_factor(kCoverage, freedom)};
}

}  // namespace gyrotherm::model
