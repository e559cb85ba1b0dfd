// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/chi_squared.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace gyrotherm::data {
namespace {

constexpr int kMostTerms = 10000;

/// γ(a, x)/Γ(a), for x < a + 1.
double lower_series(double a, double x) {
  double term = 1 / a, sum = term;
  for (int n = 1; n < kMostTerms && term > sum * std::numeric_limits<double>::epsilon(); ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * std::exp(a * std::log(x) - x - std::lgamma(a));
}

/// Γ(a, x)/Γ(a), for x ≥ a + 1, by the method of Lentz.
double upper_fraction(double a, double x) {
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, value = d;
  for (int n = 1; n < kMostTerms; ++n) {
    const double numerator = n * (a - n);
    b += 2;
    d = numerator * d + b;
    c = b + numerator / c;
    d = 1 / (d == 0 ? kTiny : d);
    c = c == 0 ? kTiny : c;
    value *= c * d;
    if (std::abs(c * d - 1) < std::numeric_limits<double>::epsilon()) break;
  }
  return value * std::exp(a * std::log(x) - x - std::lgamma(a));
}

/// The terms of Poisson's distribution that count: beyond twelve standard deviations about its mean, and 30 more, there
/// is less than 1e-16 of it.
struct PoissonTerms {
  explicit PoissonTerms(double of_mean) : mean(of_mean) {
    const double reach = 12 * std::sqrt(mean) + 30;
    first = std::floor(std::max(0.0, mean - reach));
    last = std::ceil(mean + reach);
    if (mean == 0) last = 0;
  }
  [[nodiscard]] double weight(double j) const {
    return mean == 0 ? 1.0 : std::exp(j * std::log(mean) - mean - std::lgamma(j + 1));
  }
  double mean{}, first{}, last{};
};

}  // namespace

double chi_squared_exceeds(double value, double freedom) {
  assert(value >= 0 && freedom > 0);
  const double a = freedom / 2, x = value / 2;
  if (x == 0) return 1;
  return x < a + 1 ? 1 - lower_series(a, x) : upper_fraction(a, x);
}

double chi_squared_limit(double probability, double freedom) {
  assert(probability > 0 && probability < 1);
  double low = 0, high = 1;
  while (chi_squared_exceeds(high, freedom) > probability) high *= 2;
  while (true) {  // until there is no number between
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) return high;
    (chi_squared_exceeds(middle, freedom) > probability ? low : high) = middle;
  }
}

/// Q(a + 1, x) = Q(a, x) + x^a exp(−x)/Γ(a + 1) adds what is positive, and loses nothing.
double noncentral_chi_squared_exceeds(double value, double freedom, double noncentrality) {
  assert(noncentrality >= 0);
  const PoissonTerms terms(noncentrality / 2);
  if (value == 0) return 1;
  const double x = value / 2;
  double a = freedom / 2 + terms.first, exceeds = chi_squared_exceeds(value, 2 * a);
  double step = std::exp(a * std::log(x) - x - std::lgamma(a + 1)), weight = terms.weight(terms.first), sum = 0;
  for (double j = terms.first; j <= terms.last; ++j) {
    sum += weight * exceeds;
    exceeds += step;
    a += 1;
    step *= x / a;
    weight *= terms.mean / (j + 1);
  }
  return std::min(sum, 1.0);
}

double noncentral_chi_squared_density(double value, double freedom, double noncentrality) {
  assert(value > 0 && freedom > 0 && noncentrality >= 0);
  const PoissonTerms terms(noncentrality / 2);
  const double x = value / 2;
  double a = freedom / 2 + terms.first;
  double density = 0.5 * std::exp((a - 1) * std::log(x) - x - std::lgamma(a)), weight = terms.weight(terms.first);
  double sum = 0;
  for (double j = terms.first; j <= terms.last; ++j) {
    sum += weight * density;
    density *= x / a;
    a += 1;
    weight *= terms.mean / (j + 1);
  }
  return sum;
}

}  // namespace gyrotherm::data
