#include "analysis/data/allan_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <vector>

#include "core/quantity.hpp"

namespace gyrotherm {
namespace {

/// g at lags 0, 1, 2, … intervals.
std::vector<double> generalised_covariance(const NoiseSquares& squares, double interval_h, Eigen::Index lags) {
  std::vector<double> g(static_cast<std::size_t>(lags) + 1);
  g[0] = squares(0);
  for (std::size_t lag = 1; lag < g.size(); ++lag) {
    const double t = static_cast<double>(lag) * interval_h;
    g[lag] =
        -0.5 * squares(1) * t + squares(2) * t * t * std::log(t) / (2 * std::numbers::pi) + squares(3) * t * t * t / 12;
  }
  return g;
}

/// Covariance of two second differences of the angle, that of `m` samples starting `lag` samples after that of `n`.
double covariance_at(const std::vector<double>& g, Eigen::Index lag, Eigen::Index m, Eigen::Index n) {
  constexpr double kWeights[] = {1, -2, 1};
  double sum = 0;
  for (Eigen::Index a = 0; a < 3; ++a) {
    for (Eigen::Index b = 0; b < 3; ++b) {
      sum += kWeights[a] * kWeights[b] * g[static_cast<std::size_t>(std::abs(lag + a * m - b * n))];
    }
  }
  return sum;
}

/// Stretches by their length.
using Lengths = std::map<Eigen::Index, double>;

Lengths lengths_of(const RateStretches& rates) {
  Lengths lengths;
  for (const Eigen::VectorXd& stretch : rates.values) ++lengths[stretch.size()];
  return lengths;
}

/// How many pairs (i, j) of differences over m and n samples, both inside one stretch, have i − j = lag.
double pairs_at(const Lengths& lengths, Eigen::Index lag, Eigen::Index m, Eigen::Index n) {
  double pairs = 0;
  for (const auto& [length, count] : lengths) {
    const Eigen::Index of_m = length + 1 - 2 * m, of_n = length + 1 - 2 * n;
    if (of_m < 1 || of_n < 1) continue;
    pairs += count * static_cast<double>(
                         std::max<Eigen::Index>(0, std::min(of_m, of_n + lag) - std::max<Eigen::Index>(0, lag)));
  }
  return pairs;
}

}  // namespace

NoiseSquares noise_shapes(double tau_h) {
  return NoiseSquares{3 / (tau_h * tau_h), 1 / tau_h, 2 * std::numbers::ln2 / std::numbers::pi, tau_h / 3,
                      tau_h * tau_h / 2};
}

Eigen::MatrixXd allan_covariance(const AllanCurve& curve, const RateStretches& rates, const NoiseSquares& squares) {
  const double interval_h = rates.interval_s / kSecondsPerHour;
  const Lengths lengths = lengths_of(rates);
  const auto points = static_cast<Eigen::Index>(curve.size());
  // Beyond four times the longer averaging time only the bias instability still correlates, and its squares are spent.
  constexpr Eigen::Index kReach = 4;
  const Eigen::Index longest = points > 0 ? curve.back().m : 1;
  const std::vector<double> g = generalised_covariance(squares, interval_h, (kReach + 2) * longest);
  Eigen::MatrixXd covariance(points, points);
  for (Eigen::Index p = 0; p < points; ++p) {
    for (Eigen::Index q = 0; q <= p; ++q) {
      const Eigen::Index m = curve[p].m, n = curve[q].m;
      const double tau_m = static_cast<double>(m) * interval_h, tau_n = static_cast<double>(n) * interval_h;
      const double means = squares(4) * tau_m * tau_m * tau_n * tau_n;
      double sum = 0;
      for (Eigen::Index lag = -kReach * m; lag <= kReach * m; ++lag) {
        const double pairs = pairs_at(lengths, lag, m, n);
        if (pairs == 0) continue;
        const double c = covariance_at(g, lag, m, n);
        sum += pairs * (2 * c * c + 4 * means * c);
      }
      const double differences = static_cast<double>(curve[p].differences) * curve[q].differences;
      const double scale = 4 * tau_m * tau_m * tau_n * tau_n;
      covariance(p, q) = covariance(q, p) = sum / differences / scale;
    }
  }
  return covariance;
}

}  // namespace gyrotherm
