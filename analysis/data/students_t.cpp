// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/students_t.hpp"

#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace gyrotherm::data {
namespace {

/// The continued fraction of the incomplete beta function, by the modified method of Lentz (1976): each round takes an
/// even and an odd link.
double beta_fraction(double x, double a, double b) {
  constexpr int kMostRounds = 10000;
  constexpr double kTiny = 1e-300;
  const auto not_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1, d = 1 / not_zero(1 - (a + b) * x / (a + 1)), value = d;
  const auto link = [&](double coefficient) {
    d = 1 / not_zero(1 + coefficient * d);
    c = not_zero(1 + coefficient / c);
    value *= c * d;
  };
  for (int m = 1; m < kMostRounds; ++m) {
    link(m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)));
    const double before = value;
    link(-(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)));
    if (std::abs(value - before) <= std::numeric_limits<double>::epsilon() * std::abs(value)) break;
  }
  return value;
}

/// ln Γ(a + ½) − ln Γ(a); where both are large, by the series of their difference (from Abramowitz and Stegun 6.1.41),
/// in which nothing cancels.
double log_gamma_step(double a) {
  constexpr double kLarge = 100;
  if (a < kLarge) return std::lgamma(a + 0.5) - std::lgamma(a);
  return 0.5 * std::log(a) - 1 / (8 * a) + 1 / (192 * a * a * a);
}

/// I_x(a, ½), x between 0 and 1, `rest` being 1 − x, which the caller knows without cancellation. The fraction
/// converges fast on one side of (a + 1)/(a + 5/2), and I_x(a, b) = 1 − I_{1−x}(b, a).
double incomplete_beta(double x, double rest, double a) {
  constexpr double b = 0.5;
  if (x <= 0 || rest <= 0) return x <= 0 ? 0 : 1;
  const double log_x = rest < b ? std::log1p(-rest) : std::log(x);
  const double front = std::exp(log_gamma_step(a) + a * log_x) * std::sqrt(rest * std::numbers::inv_pi);
  return x < (a + 1) / (a + b + 2) ? front * beta_fraction(x, a, b) / a : 1 - front * beta_fraction(rest, b, a) / b;
}

}  // namespace

double students_t_probability(double t, double degrees_of_freedom) {
  assert(degrees_of_freedom > 0);
  constexpr double kNearlyNormal = 1e6;
  if (degrees_of_freedom > kNearlyNormal) {
    const double part = 1 / (4 * degrees_of_freedom);
    return 0.5 * std::erfc(-t * (1 - part) / std::sqrt(1 + 2 * part * t * t) / std::numbers::sqrt2);
  }
  const double square = t * t, sum = degrees_of_freedom + square;
  const double beyond = 0.5 * incomplete_beta(degrees_of_freedom / sum, square / sum, 0.5 * degrees_of_freedom);
  return t >= 0 ? 1 - beyond : beyond;
}

double coverage_factor(double share, double degrees_of_freedom) {
  assert(share > 0 && share < 1);
  const double wanted = 0.5 * (1 + share);
  double low = 0, high = 1;
  while (students_t_probability(high, degrees_of_freedom) < wanted) high *= 2;
  while (true) {  // until there is no number between
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) return high;
    (students_t_probability(middle, degrees_of_freedom) < wanted ? low : high) = middle;
  }
}

}  // namespace gyrotherm::data
