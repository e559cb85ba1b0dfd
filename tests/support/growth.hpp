// SPDX-License-Identifier: Apache-2.0
/// Growth of processor time with the size of the work. Independent of the machine and of sanitizers.
#pragma once

#include <ctime>

namespace gyrotherm::tests {

/// Largest accepted growth for ten times the size: linear time gives 10, quadratic time 100.
inline constexpr double kLargestLinearGrowth = 40;

/// Returns the processor time of work(10 · size) divided by that of work(size).
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
