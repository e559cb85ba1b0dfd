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
  double elapsed_s = 0;  // since a temperature was known
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double temperature_c = history.temperature_c(k, thermometer);
    elapsed_s += history.elapsed_s(k);
    values(k) = std::isnan(temperature_c) ? temperature_c : lag.push(temperature_c, elapsed_s);
    if (!std::isnan(temperature_c)) elapsed_s = 0;
  }
  return values;
}

}  // namespace gyrotherm::data
