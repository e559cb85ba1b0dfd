// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/distributions.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/policies/policy.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cassert>

namespace gyrotherm::data {
namespace {

/// Error policy: undefined results are NaN or infinite; nothing throws.
using DistributionPolicy =
    boost::math::policies::policy<boost::math::policies::domain_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::pole_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
                                  boost::math::policies::evaluation_error<boost::math::policies::ignore_error>>;

using ChiSquared = boost::math::chi_squared_distribution<double, DistributionPolicy>;
using NoncentralChiSquared = boost::math::non_central_chi_squared_distribution<double, DistributionPolicy>;
using StudentsT = boost::math::students_t_distribution<double, DistributionPolicy>;

}  // namespace

double chi_squared_exceeds(double value, double freedom) {
  assert(value >= 0 && freedom > 0);
  return cdf(complement(ChiSquared(freedom), value));
}

double chi_squared_limit(double probability, double freedom) {
  assert(probability > 0 && probability < 1);
  return quantile(complement(ChiSquared(freedom), probability));
}

double noncentral_chi_squared_exceeds(double value, double freedom, double noncentrality) {
  assert(noncentrality >= 0);
  return cdf(complement(NoncentralChiSquared(freedom, noncentrality), value));
}

double noncentral_chi_squared_density(double value, double freedom, double noncentrality) {
  assert(value > 0 && freedom > 0 && noncentrality >= 0);
  return pdf(NoncentralChiSquared(freedom, noncentrality), value);
}

double students_t_probability(double t, double degrees_of_freedom) {
  assert(degrees_of_freedom > 0);
  return cdf(StudentsT(degrees_of_freedom), t);
}

double coverage_factor(double share, double degrees_of_freedom) {
  assert(share > 0 && share < 1);
  return quantile(complement(StudentsT(degrees_of_freedom), 0.5 * (1 - share)));
}

double binomial_at_most(double successes, double trials, double probability) {
  assert(successes >= 0 && successes <= trials && probability > 0 && probability < 1);
  if (!(successes < trials)) return 1;
  return boost::math::ibeta(trials - successes, successes + 1, 1 - probability, DistributionPolicy());
}

std::pair<double, double> binomial_interval(double successes, double trials, double share) {
  assert(successes >= 0 && successes <= trials && trials > 0 && share > 0 && share < 1);
  const double tail = (1 - share) / 2, failures = trials - successes;
  const double low = successes > 0 ? boost::math::ibeta_inv(successes, failures + 1, tail, DistributionPolicy()) : 0;
  const double high = failures > 0 ? boost::math::ibetac_inv(successes + 1, failures, tail, DistributionPolicy()) : 1;
  return {low, high};
}

}  // namespace gyrotherm::data
