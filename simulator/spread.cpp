#include "simulator/spread.hpp"

#include "simulator/random.hpp"

namespace gyrotherm {
namespace {

void scatter_bias(BiasParameters& bias, double sigma, RandomStream random) {
  for (double* coefficient : {&bias.linear_deg_per_h_per_k, &bias.quadratic_deg_per_h_per_k2, &bias.wave_deg_per_h,
                              &bias.arm_deg_per_h_per_k}) {
    *coefficient *= random.log_normal(sigma);
  }
  for (double& coefficient : bias.gradient_deg_per_h_per_k) coefficient *= random.log_normal(sigma);
}

}  // namespace

WorldParameters draw_gyro(WorldParameters type, std::uint64_t seed) {
  if (seed == 0) return type;
  const auto spread = type.spread;
  RandomStream capacity(seed, RandomPurpose::capacity_spread);
  RandomStream film(seed, RandomPurpose::film_spread);
  RandomStream offset(seed, RandomPurpose::thermometer_offset);
  RandomStream turn_on(seed, RandomPurpose::turn_on);
  for (double& c : type.network.capacity_j_per_k) c *= capacity.log_normal(spread.capacity);
  for (double& g : type.network.film_w_per_k) g *= film.log_normal(spread.film);
  for (double& error_k : type.thermometers.offset_k) error_k += spread.offset_k * offset.normal();
  type.gyro.turn_on_deg_per_h += spread.turn_on_deg_per_h * turn_on.normal();
  scatter_bias(type.bias, spread.bias, RandomStream(seed, RandomPurpose::bias_spread));
  return type;
}

}  // namespace gyrotherm
