// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/chi_squared.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <cassert>

#include "analysis/data/distribution_policy.hpp"

namespace gyrotherm::data {
namespace {

using ChiSquared = boost::math::chi_squared_distribution<double, DistributionPolicy>;
using NoncentralChiSquared = boost::math::non_central_chi_squared_distribution<double, DistributionPolicy>;

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

}  // namespace gyrotherm::data
