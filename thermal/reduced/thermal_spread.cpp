#include "thermal/reduced/thermal_spread.hpp"

namespace gyrotherm {
namespace {

/// Shares the sum of two powers so that left over right changes by `factor`.
void split(double& left_w, double& right_w, double factor) {
  const double sum = left_w + right_w;
  if (!(sum > 0)) return;
  left_w *= factor;
  const double scale = sum / (left_w + right_w);
  left_w *= scale;
  right_w *= scale;
}

}  // namespace

ReducedModel perturbed(const ReducedModel& model, const ThermalSpread& spread, RandomStream& random) {
  ReducedModel other = model;
  const double pace = 1 / random.log_normal(spread.capacity);
  for (std::size_t m = 0; m < static_cast<std::size_t>(ThermalCoefficient::film); ++m)
    other.conduction_per[m] *= random.log_normal(spread.gap);
  const double film = random.log_normal(spread.film);
  other.still_film_w_per_m2_k *= film;
  other.chamber_film_w_per_m2_k *= film;
  const double gain = random.log_normal(spread.power);
  const double preamplifier = random.log_normal(spread.power);
  const double ballast = random.log_normal(spread.power);
  auto& [gain_left, gain_right, preamplifier_w, ballast_left, ballast_right] = other.powers_w;
  for (double* w : {&gain_left, &gain_right}) *w *= gain;
  preamplifier_w *= preamplifier;
  for (double* w : {&ballast_left, &ballast_right}) *w *= ballast;
  split(gain_left, gain_right, random.log_normal(spread.arms));
  split(ballast_left, ballast_right, random.log_normal(spread.arms));
  // More capacity, in the basis that makes it one: all else becomes less.
  other.conduction *= pace;
  for (auto& matrix : other.conduction_per) matrix *= pace;
  other.inputs *= pace;
  other.film_ambient *= pace;
  return other;
}

}  // namespace gyrotherm
