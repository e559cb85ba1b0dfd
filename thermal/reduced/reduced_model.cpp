#include "thermal/reduced/reduced_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace gyrotherm {

ThermalCoefficients coefficients_at(const ReducedModel& model, double air_c, GyroFilm film) {
  return coefficients_at(model.air, std::clamp(air_c, kColdestGapAir_c, kHottestGapAir_c),
                         film == GyroFilm::still ? model.still_film_w_per_m2_k : model.chamber_film_w_per_m2_k);
}

Eigen::MatrixXd conduction_at(const ReducedModel& model, const ThermalCoefficients& c) {
  Eigen::MatrixXd sum = model.conduction;
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) sum += c[m] * model.conduction_per[m];
  return sum;
}

Eigen::MatrixXd inputs_at(const ReducedModel& model, const ThermalCoefficients& c) {
  Eigen::MatrixXd sum = model.inputs;
  sum.col(static_cast<Eigen::Index>(ThermalInput::ambient)) +=
      c[static_cast<std::size_t>(ThermalCoefficient::film)] * model.film_ambient;
  return sum;
}

Eigen::MatrixXd states_at(const ReducedModel& model, const ThermalCoefficients& c, double s) {
  Eigen::MatrixXd balance = conduction_at(model, c);
  balance.diagonal().array() += s;
  return balance.ldlt().solve(inputs_at(model, c));
}

Eigen::Vector<double, kThermalInputs> switched_on(const ReducedModel& model, double air_c) {
  Eigen::Vector<double, kThermalInputs> u;
  u[0] = air_c;
  for (std::size_t i = 1; i < kThermalInputs; ++i) u[static_cast<Eigen::Index>(i)] = model.powers_w[i - 1];
  return u;
}

}  // namespace gyrotherm
