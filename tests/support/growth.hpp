// SPDX-License-Identifier: Apache-2.0
/// How the time of a piece of work grows with its size: the same on any machine, and under a sanitizer.
#pragma once

#include <ctime>

namespace gyrotherm::tests {

/// Far from the square: what takes its time as it is long takes ten times as much for ten times the size.
inline constexpr double kNearlyInProportion = 40;

/// The processor's time of work(10 · size), as a multiple of that of work(size).
template <class Work>
double growth_over_ten(Work work, int size) {
  const auto cost_of = [&](int of_size) {
    const auto began = std::clock();
    work(of_size);
    return static_cast<double>(std::clock() - began + 1);
  };
  const double small = cost_of(size);
  return cost_of(10 * size) / small;
}

}  // namespace gyrotherm::tests
