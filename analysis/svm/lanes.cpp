// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/lanes.hpp"

namespace gyrotherm::svm {

GYROTHERM_CLONES
void exponentiate(const double* values, std::ptrdiff_t count, double scale, double* out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    double x = values[i] * scale;
    exponentiate<double, long long>(x);
    out[i] = x;
  }
}

}  // namespace gyrotherm::svm
