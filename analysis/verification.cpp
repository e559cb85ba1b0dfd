#include "analysis/verification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace gyrotherm {
namespace {

constexpr double kCornerSeconds = 600;

using Rows = std::vector<Eigen::Index>;

template <class Wanted>
Rows rows_where(const Clusters& clusters, Wanted wanted) {
  Rows rows;
  for (Eigen::Index k = 0; k < clusters.start_s.size(); ++k) {
    if (wanted(k)) rows.push_back(k);
  }
  return rows;
}

Figures figures_at(const Eigen::VectorXd& values, const Rows& rows) { return figures_of(values(rows)); }

/// Start and end of a segment's samples; start > end if it has none.
struct Stretch {
  double start_s = std::numeric_limits<double>::infinity();
  double end_s = -std::numeric_limits<double>::infinity();
};

std::vector<Stretch> stretches_of(const Dataset& dataset) {
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

/// Where the asked-for rate of change changes: each segment's start, but not the first one's, nor that of a hold after
/// a hold at the same temperature.
std::vector<double> corners_of(const Dataset& dataset, const std::vector<Stretch>& stretches) {
  std::vector<double> corners;
  for (std::size_t s = 1; s < stretches.size(); ++s) {
    const auto &before = dataset.segments[s - 1], &after = dataset.segments[s];
    const bool goes_on = before.hold && after.hold && before.target == after.target;
    const bool recorded =
        stretches[s].start_s < stretches[s].end_s && stretches[s - 1].start_s < stretches[s - 1].end_s;
    if (recorded && !goes_on) corners.push_back(stretches[s].start_s);
  }
  return corners;
}

Rows rows_after(const std::vector<double>& corners, const Clusters& clusters) {
  return rows_where(clusters, [&](Eigen::Index k) {
    return std::ranges::any_of(corners, [&](double corner_s) {
      return clusters.start_s(k) < corner_s + kCornerSeconds && clusters.start_s(k) + clusters.length_s > corner_s;
    });
  });
}

std::vector<SegmentFigures> segment_figures(const Dataset& dataset, const Clusters& clusters,
                                            const Eigen::VectorXd& residual, const std::vector<Stretch>& stretches) {
  std::vector<SegmentFigures> figures;
  for (std::size_t s = 0; s < dataset.segments.size(); ++s) {
    const auto segment = static_cast<int>(s);
    const Rows rows = rows_where(clusters, [&](Eigen::Index k) { return clusters.segment(k) == segment; });
    if (rows.empty()) continue;
    figures.push_back({.segment = segment,
                       .name = dataset.segments[s].name,
                       .hold = dataset.segments[s].hold,
                       .start_s = stretches[s].start_s,
                       .duration_s = stretches[s].end_s - stretches[s].start_s,
                       .mean_temperature_c = clusters.temperature_c.col(0)(rows).mean(),
                       .mean_bias_deg_per_h = clusters.bias_deg_per_h(rows).mean(),
                       .residual = figures_at(residual, rows)});
  }
  return figures;
}

int count_outside(const Model& model, const SampleMatrix& inputs) {
  int outside = 0;
  for (Eigen::Index k = 0; k < inputs.rows(); ++k) {
    const bool inside = (inputs.row(k).array() >= model.input_min.array()).all() &&
                        (inputs.row(k).array() <= model.input_max.array()).all();
    outside += inside ? 0 : 1;
  }
  return outside;
}

/// Whether the model saw any of these clusters: the same run, and a stretch of it that overlaps.
bool trained_on(const Model& model, const Dataset& dataset, const Clusters& clusters) {
  const double from_s = clusters.start_s(0), to_s = clusters.start_s(clusters.start_s.size() - 1) + clusters.length_s;
  return std::ranges::any_of(model.trained_on, [&](const TrainingRecord& record) {
    return record.run_id == dataset.run_id && from_s < record.to_s && record.from_s < to_s;
  });
}

std::vector<std::string> warnings_of(const Verification& result, const Model& model, const Clusters& clusters) {
  std::vector<std::string> warnings;
  if (result.trained_on_this) {
    warnings.push_back("the model was trained on this record: these figures are in-sample and verify nothing");
  }
  if (result.compensated.std < result.floor.deg_per_h) {
    warnings.push_back(fmt::format("over-fit: the residual STD, {:.4g} °/h, is below the noise floor, {:.4g} °/h",
                                   result.compensated.std, result.floor.deg_per_h));
  }
  if (result.outside_trained_range > 0) {
    warnings.push_back(fmt::format("{} of {} clusters have an input outside the trained range",
                                   result.outside_trained_range, result.compensated.count));
  }
  if (clusters.length_s != model.cluster_length_s) {
    warnings.push_back(fmt::format("the model was trained on means over {} s, these are over {} s",
                                   model.cluster_length_s, clusters.length_s));
  }
  return warnings;
}

}  // namespace

Result<Verification> verify(const Model& model, const Dataset& dataset, const Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const Eigen::VectorXd residual = clusters.bias_deg_per_h - predict(model, *inputs);
  const std::vector<Stretch> stretches = stretches_of(dataset);
  const auto rows_of = [&](bool hold) {
    return rows_where(clusters, [&](Eigen::Index k) {
      return clusters.segment(k) >= 0 && dataset.segments[clusters.segment(k)].hold == hold;
    });
  };
  Verification result;
  result.run_id = dataset.run_id;
  result.simulated = dataset.simulated;
  result.trained_on_this = trained_on(model, dataset, clusters);
  result.raw = figures_of(clusters.bias_deg_per_h);
  result.compensated = figures_of(residual);
  result.ramps = figures_at(residual, rows_of(false));
  result.holds = figures_at(residual, rows_of(true));
  result.corners = figures_at(residual, rows_after(corners_of(dataset, stretches), clusters));
  result.floor = noise_floor(clusters, dataset.segments);
  result.residual_deg_per_h = residual;
  result.segments = segment_figures(dataset, clusters, residual, stretches);
  result.outside_trained_range = count_outside(model, *inputs);
  result.warnings = warnings_of(result, model, clusters);
  return result;
}

}  // namespace gyrotherm
