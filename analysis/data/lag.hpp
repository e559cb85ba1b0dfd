// SPDX-License-Identifier: Apache-2.0
/// Causal first-order lags of temperatures: what a body that follows a thermometer slowly has not yet followed.
#pragma once

#include <Eigen/Core>
#include <limits>

namespace gyrotherm::data {

/// A body that follows the temperature T of a thermometer with the time constant τ: dF/dt = (T − F)/τ. It starts in
/// balance: F is the first temperature. T is taken as a staircase of the temperatures given, each since the one before
/// it, for which T_k − F_k = exp(−Δt/τ) (T_k − F_{k−1}) is the exact solution (the zero-order-hold equivalent;
/// Franklin, Powell, Workman, Digital Control of Dynamic Systems (1998), §4.3.3). A gap is a long step: over one of
/// many τ the body is in balance again.
class FirstOrderLag {
 public:
  explicit FirstOrderLag(double time_constant_s) : time_constant_s_(time_constant_s) {}

  /// By how much the body lags behind, T − F in K, once this temperature has lasted for `elapsed_s`.
  double push(double temperature_c, double elapsed_s);

 private:
  double time_constant_s_;
  double followed_c_ = std::numeric_limits<double>::quiet_NaN();  ///< F; NaN before the first temperature
};

/// The temperatures of whole runs, one run after the other, a row per cluster, of those too in which another reading is
/// missing: what lags are made of where a part of the clusters is looked at.
struct TemperatureHistory {
  Eigen::VectorXd elapsed_s;      ///< since the cluster before it in its run; infinite for the first of a run
  Eigen::MatrixXd temperature_c;  ///< clusters × thermometers; NaN where one of its readings is missing
};

/// The lag of one thermometer in each row of the history, K: 0 in the first of each run that has its temperature, NaN
/// where that is not known, which is a longer step.
[[nodiscard]] Eigen::VectorXd lag_of(const TemperatureHistory& history, Eigen::Index thermometer,
                                     double time_constant_s);

}  // namespace gyrotherm::data
