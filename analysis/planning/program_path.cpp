// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/program_path.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm::planning {

int count_starts(const ProgramPath& path) { return path.start.size() > 0 ? path.start.maxCoeff() + 1 : 0; }

ProgramPath join(const ProgramPath& first, const ProgramPath& then) {
  ProgramPath path{.length_s = first.length_s, .set_point_c = {}, .start = {}};
  const Eigen::Index before = first.set_point_c.size(), after = then.set_point_c.size();
  path.set_point_c.resize(before + after);
  path.set_point_c << first.set_point_c, then.set_point_c;
  path.start.resize(before + after);
  path.start.head(before) = first.start;
  const bool continues = before > 0 && after > 0 && first.start(before - 1) >= 0 && then.start(0) >= 0;
  const int offset = count_starts(first) - (continues ? 1 : 0);
  for (Eigen::Index k = 0; k < after; ++k) path.start(before + k) = then.start(k) < 0 ? -1 : then.start(k) + offset;
  return path;
}

ProgramPath recorded_path(const data::Dataset& dataset, double length_s) {
  ProgramPath path{.length_s = length_s, .set_point_c = {}, .start = {}};
  if (dataset.time_s.size() == 0) return path;
  const double span_s = dataset.time_s(dataset.time_s.size() - 1) - dataset.time_s(0);
  const auto count = static_cast<Eigen::Index>(std::floor(span_s / length_s)) + 1;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(count);
  Eigen::VectorXi samples = Eigen::VectorXi::Zero(count);
  path.start.setConstant(count, -2);
  int start = -1;
  bool was_off = true;
  for (Eigen::Index i = 0; i < dataset.time_s.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(std::floor((dataset.time_s(i) - dataset.time_s(0)) / length_s));
    const auto segment = static_cast<std::size_t>(std::max(0, dataset.segment(i)));
    const bool is_off = segment < dataset.segments.size() && dataset.segments[segment].unit.off;
    if (was_off && !is_off) ++start;
    was_off = is_off;
    if (std::isfinite(dataset.set_point_c(i))) {
      sum(k) += dataset.set_point_c(i);
      ++samples(k);
    }
    path.start(k) = is_off ? -1 : start;
  }
  path.set_point_c.setConstant(count, dataset.set_point_c(0));
  for (Eigen::Index k = 0; k < count; ++k) {
    if (samples(k) > 0)
      path.set_point_c(k) = sum(k) / samples(k);
    else if (k > 0)
      path.set_point_c(k) = path.set_point_c(k - 1);
    if (path.start(k) == -2) path.start(k) = k > 0 ? path.start(k - 1) : 0;
  }
  return path;
}

}  // namespace gyrotherm::planning
