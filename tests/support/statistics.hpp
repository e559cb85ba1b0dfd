// SPDX-License-Identifier: Apache-2.0
/// Plain statistics of a series.
#pragma once

#include <cmath>
#include <numeric>
#include <vector>

namespace gyrotherm::tests {

inline double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

inline double standard_deviation(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

/// Returns means over 100 consecutive values.
inline std::vector<double> clusters_of(const std::vector<double>& values) {
  std::vector<double> means;
  for (std::size_t i = 0; i + 100 <= values.size(); i += 100) {
    means.push_back(std::accumulate(values.begin() + i, values.begin() + i + 100, 0.0) / 100);
  }
  return means;
}

}  // namespace gyrotherm::tests
