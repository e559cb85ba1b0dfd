#include "analysis/statistics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace gyrotherm {
namespace {

constexpr double kLastHourSeconds = 3600;

/// Clusters first … last of one segment that lie wholly inside it.
struct Hold {
  Eigen::Index first{}, last{};
};

std::vector<Hold> holds_of(const Clusters& clusters, const std::vector<RunInfo::SegmentInfo>& segments) {
  const Eigen::Index count = clusters.start_s.size();
  if (segments.empty()) return count > 0 ? std::vector<Hold>{{0, count - 1}} : std::vector<Hold>{};
  std::vector<Hold> holds;
  int open = -1;
  for (Eigen::Index k = 0; k < count; ++k) {
    const int segment = clusters.segment(k);
    const bool inside = segment >= 0 && segments[segment].hold && clusters.last_segment(k) == segment;
    if (inside && segment == open)
      holds.back().last = k;
    else if (inside)
      holds.push_back({k, k});
    open = inside ? segment : -1;
  }
  return holds;
}

bool neighbours(const Clusters& clusters, Eigen::Index k) {
  const double step_s = clusters.start_s(k + 1) - clusters.start_s(k);
  return std::abs(step_s - clusters.length_s) < 0.5 * clusters.length_s;
}

}  // namespace

Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values) {
  const auto count = static_cast<double>(values.size());
  Figures figures{.count = static_cast<int>(values.size())};
  if (figures.count == 0) return figures;
  figures.mean = values.mean();
  figures.rmse = std::sqrt(values.squaredNorm() / count);
  figures.max_abs = values.cwiseAbs().maxCoeff();
  if (figures.count > 1) figures.std = std::sqrt((values.array() - figures.mean).square().sum() / (count - 1));
  return figures;
}

Improvement improvement(double std_raw, double std_three_point, double std_multi_point) {
  Improvement result;
  result.three_point_from_original = 1 - std_three_point / std_raw;
  result.multi_point_from_original = 1 - std_multi_point / std_raw;
  result.paper_ratio = result.multi_point_from_original / result.three_point_from_original - 1;
  result.residual_reduction = 1 - std_multi_point / std_three_point;
  return result;
}

NoiseFloor noise_floor(const Clusters& clusters, const std::vector<RunInfo::SegmentInfo>& segments) {
  assert(clusters.last_segment.size() == clusters.segment.size());
  double sum = 0;
  NoiseFloor floor;
  for (const Hold& hold : holds_of(clusters, segments)) {
    const double from_s = clusters.start_s(hold.last) + clusters.length_s - kLastHourSeconds;
    for (Eigen::Index k = hold.first; k < hold.last; ++k) {
      if (clusters.start_s(k) < from_s - 0.5 * clusters.length_s || !neighbours(clusters, k)) continue;
      const double difference = clusters.bias_deg_per_h(k + 1) - clusters.bias_deg_per_h(k);
      sum += difference * difference;
      ++floor.differences;
    }
  }
  floor.deg_per_h =
      floor.differences > 0 ? std::sqrt(sum / (2 * floor.differences)) : std::numeric_limits<double>::quiet_NaN();
  return floor;
}

double overlapping_allan_deviation(const Eigen::Ref<const Eigen::VectorXd>& values, int m) {
  assert(m >= 1 && values.size() >= 2 * m);
  const Eigen::Index terms = values.size() + 1 - 2 * m;
  Eigen::VectorXd angle(values.size() + 1);
  angle(0) = 0;
  for (Eigen::Index i = 0; i < values.size(); ++i) angle(i + 1) = angle(i) + values(i);
  const auto second_difference = angle.tail(terms) - 2 * angle.segment(m, terms) + angle.head(terms);
  return std::sqrt(second_difference.squaredNorm() / (2.0 * m * m * static_cast<double>(terms)));
}

}  // namespace gyrotherm
