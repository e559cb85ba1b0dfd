// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/lag.hpp"

#include <cassert>
#include <cmath>

namespace gyrotherm::data {

double FirstOrderLag::push(double temperature_c, double elapsed_s) {
  assert(elapsed_s > 0);
  if (std::isnan(followed_c_)) followed_c_ = temperature_c;
  const double behind = std::exp(-elapsed_s / time_constant_s_) * (temperature_c - followed_c_);
  followed_c_ = temperature_c - behind;
  return behind;
}

Eigen::VectorXd lag_of(const TemperatureHistory& history, Eigen::Index thermometer, double time_constant_s) {
  FirstOrderLag lag(time_constant_s);
  Eigen::VectorXd values(history.elapsed_s.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    values(k) = lag.push(history.temperature_c(k, thermometer), history.elapsed_s(k));
  }
  return values;
}

}  // namespace gyrotherm::data
