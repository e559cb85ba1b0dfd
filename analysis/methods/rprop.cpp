// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/rprop.hpp"

#include <algorithm>
#include <cassert>

namespace gyrotherm::methods {

RpropSteps::RpropSteps(Eigen::Index coordinates)
    : sizes_(Eigen::VectorXd::Constant(coordinates, 0.2)), before_(Eigen::VectorXd::Zero(coordinates)) {}

Eigen::VectorXd RpropSteps::next(Eigen::VectorXd gradient) {
  constexpr double kLongestStep = 1, kShortestStep = 1e-6, kGrowth = 1.2, kShrinking = 0.5;
  assert(gradient.size() == sizes_.size());
  for (Eigen::Index k = 0; k < gradient.size(); ++k) {
    const double agreement = gradient(k) * before_(k);
    if (agreement > 0) sizes_(k) = std::min(sizes_(k) * kGrowth, kLongestStep);
    if (agreement >= 0) continue;
    sizes_(k) = std::max(sizes_(k) * kShrinking, kShortestStep);
    gradient(k) = 0;
  }
  before_ = gradient;
  return gradient.array().sign() * sizes_.array();
}

}  // namespace gyrotherm::methods
