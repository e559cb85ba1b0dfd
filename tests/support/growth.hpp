// SPDX-License-Identifier: Apache-2.0
/// Measures how processor time grows with the size of the work, independent of the machine and of sanitizers.
#pragma once

#include <ctime>

namespace gyrotherm::tests {

/// Greatest growth that counts as linear for ten times the size. Linear time gives 10, quadratic time 100.
inline constexpr double kLargestLinearGrowth = 40;

/// Returns the processor time of work(10 · size) divided by that of work(size).
template <class Work>
double growth_over_ten(Work work, int size) {
  const auto measure = [&](int n) {
    const auto began = std::clock();
    work(n);
    return static_cast<double>(std::clock() - began + 1);
  };
  const double small = measure(size);
  return measure(10 * size) / small;
}

}  // namespace gyrotherm::tests
