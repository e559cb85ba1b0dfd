#include "thermal/thermal_samples.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm {
namespace {

constexpr double kColdest_c = -60;
constexpr double kHottest_c = 80;

std::vector<double> evenly(double first, double last, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(first + (last - first) * i / (count - 1));
  return values;
}

/// 0, and evenly in the logarithm between the slowest mode of such a gyro and what its thermometers hardly see.
std::vector<double> rates(double slowest, double fastest, int count) {
  std::vector<double> values{0};
  for (const double exponent : evenly(std::log(slowest), std::log(fastest), count))
    values.push_back(std::exp(exponent));
  return values;
}

/// Conductivities of gaps that are all alike: those of the gap that conducts worst, from cold to heat, and up to
/// 0.06 W/(m·K) at least.
struct Span {
  double lowest;
  double highest;
  [[nodiscard]] double at(double share) const { return lowest + share * (highest - lowest); }
};

Span alike(const ReducedModel& about) {
  constexpr double kHighest = 0.06;
  const auto cold = coefficients_at(about, kColdest_c, GyroFilm::still);
  const auto hot = coefficients_at(about, kHottest_c, GyroFilm::still);
  return {std::min({cold[0], cold[1], cold[2]}), std::max(kHighest, std::min({hot[0], hot[1], hot[2]}))};
}

double film_of(const ReducedModel& about, GyroFilm film) {
  return film == GyroFilm::still ? about.still_film_w_per_m2_k : about.chamber_film_w_per_m2_k;
}

/// All gaps alike, at `share` of their span.
ThermalPoint gaps_alike(const ReducedModel& about, double share, GyroFilm film, double rate_per_s) {
  const double k = alike(about).at(share);
  return {{k, k, k, film_of(about, film)}, rate_per_s};
}

/// Under both films: the air's own coefficients at some temperatures, and all gaps alike at some shares of their span.
std::vector<ThermalPoint> points(const ReducedModel& about, const std::vector<double>& air_c,
                                 const std::vector<double>& shares, const std::vector<double>& rates_per_s) {
  std::vector<ThermalPoint> found;
  for (const double s : rates_per_s) {
    for (const auto film : {GyroFilm::still, GyroFilm::chamber}) {
      for (const double t : air_c) found.push_back({coefficients_at(about, t, film), s});
      for (const double share : shares) found.push_back(gaps_alike(about, share, film, s));
    }
  }
  return found;
}

}  // namespace

std::vector<ThermalPoint> candidate_points(const ReducedModel& about) {
  return points(about, evenly(kColdest_c, kHottest_c, 4), {0, 1}, rates(5e-5, 1e-1, 9));
}

std::vector<ThermalPoint> dense_points(const ReducedModel& about) {
  return points(about, evenly(kColdest_c, kHottest_c, 11), evenly(0, 1, 5), rates(2e-5, 1.5e-1, 26));
}

std::vector<ThermalPoint> check_points(const ReducedModel& about) {
  return {gaps_alike(about, 0.05, GyroFilm::still, 0),
          gaps_alike(about, 0.9, GyroFilm::chamber, 0),
          gaps_alike(about, 0.2, GyroFilm::still, 5e-4),
          gaps_alike(about, 0.63, GyroFilm::chamber, 3e-3),
          {coefficients_at(about, 33, GyroFilm::chamber), 1.3e-3},
          {coefficients_at(about, -37, GyroFilm::still), 2.3e-4}};
}

}  // namespace gyrotherm
