#include "analysis/data/noise_floor.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <limits>

namespace gyrotherm {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

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

/// Two differences that share a cluster are correlated by −½: the sum of D squares, P of them followed by such a one,
/// has the relative variance (2 + P/D)/D.
double relative_error(int differences, int followed) {
  const double d = differences;
  return 0.5 * std::sqrt((2 + followed / d) / d);
}

}  // namespace

NoiseFloor noise_floor(const Clusters& clusters, const std::vector<RunInfo::SegmentInfo>& segments) {
  assert(clusters.last_segment.size() == clusters.segment.size());
  double sum = 0;
  int followed = 0;
  NoiseFloor floor;
  for (const Hold& hold : holds_of(clusters, segments)) {
    const double from_s = clusters.start_s(hold.last) + clusters.length_s - kQuietSeconds;
    Eigen::Index before = -1;
    for (Eigen::Index k = hold.first; k < hold.last; ++k) {
      if (clusters.start_s(k) < from_s - 0.5 * clusters.length_s || !neighbours(clusters, k)) continue;
      const double difference = clusters.bias_deg_per_h(k + 1) - clusters.bias_deg_per_h(k);
      sum += difference * difference;
      ++floor.differences;
      followed += before == k - 1 && before >= 0 ? 1 : 0;
      before = k;
    }
  }
  floor.deg_per_h = floor.differences > 0 ? std::sqrt(sum / (2 * floor.differences)) : kUnknown;
  floor.error_deg_per_h =
      floor.differences > 0 ? floor.deg_per_h * relative_error(floor.differences, followed) : kUnknown;
  return floor;
}

double expected_in_sample_std(const NoiseFloor& floor, double effective_parameters, int clusters) {
  const bool known = effective_parameters > 0 && effective_parameters < clusters;
  return known ? floor.deg_per_h * std::sqrt(1 - effective_parameters / clusters) : kUnknown;
}

std::optional<std::string> over_fit_warning(const Figures& residual, const NoiseFloor& floor,
                                            double effective_parameters) {
  constexpr double kCoverage = 2;
  const double of_residual = std_error(residual);
  const double bar = kCoverage * std::hypot(std::isfinite(of_residual) ? of_residual : 0, floor.error_deg_per_h);
  if (!(residual.std < floor.deg_per_h - bar)) return std::nullopt;
  std::string text = fmt::format(
      "over-fit: the residual STD, {:.4g} °/h, is below the noise floor, {:.4g} °/h, by "
      "more than their error bar, {:.2g} °/h",
      residual.std, floor.deg_per_h, bar);
  const double expected = expected_in_sample_std(floor, effective_parameters, residual.count);
  if (std::isfinite(expected)) {
    text += fmt::format("; {:.0f} effective parameters on {} clusters explain {:.4g} °/h", effective_parameters,
                        residual.count, expected);
  }
  return text;
}

}  // namespace gyrotherm
