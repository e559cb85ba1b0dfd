// SPDX-License-Identifier: Apache-2.0
/// A program of the chamber as set points per cluster: the form in which programs are compared before they run.
#pragma once

#include <Eigen/Core>

#include "analysis/data/dataset.hpp"

namespace gyrotherm::planning {

/// The set points of a program, one row per cluster.
struct ProgramPath {
  double length_s = 100;
  Eigen::VectorXd set_point_c;
  /// Number of the power-on that each cluster belongs to, counted from 0; −1 while the unit is off. The first power-on
  /// has the number 0 also if the path begins with the unit off.
  Eigen::VectorXi start;
};

/// Returns the number of power-ons of a path.
[[nodiscard]] int count_starts(const ProgramPath& path);

/// Returns `first` followed by `then`, with the power-ons of `then` numbered after those of `first`. If the unit
/// is on at the end of `first` and at the beginning of `then`, the first power-on of `then` continues the last one of
/// `first`.
[[nodiscard]] ProgramPath join(const ProgramPath& first, const ProgramPath& then);

/// Returns the path of a recorded run. Seconds without a record are bridged by the last known set point.
[[nodiscard]] ProgramPath recorded_path(const data::Dataset& dataset, double length_s = 100);

}  // namespace gyrotherm::planning
