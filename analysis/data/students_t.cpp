// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/students_t.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cassert>

#include "analysis/data/distribution_policy.hpp"

namespace gyrotherm::data {
namespace {

using StudentsT = boost::math::students_t_distribution<double, DistributionPolicy>;

}  // namespace

double students_t_probability(double t, double degrees_of_freedom) {
  assert(degrees_of_freedom > 0);
  return cdf(StudentsT(degrees_of_freedom), t);
}

double coverage_factor(double share, double degrees_of_freedom) {
  assert(share > 0 && share < 1);
  return quantile(complement(StudentsT(degrees_of_freedom), 0.5 * (1 - share)));
}

}  // namespace gyrotherm::data
