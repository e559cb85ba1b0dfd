// SPDX-License-Identifier: Apache-2.0
/// Measures the error of a reduced model in the time domain, relative to the full model, in two temperature programs.
/// The file of a reduced model contains the results in [error].
#pragma once

#include <optional>

#include "core/result.hpp"
#include "simulator/thermal/conjugate_gradients.hpp"
#include "simulator/thermal/hex20.hpp"
#include "simulator/thermal/model_order_reduction.hpp"

namespace gyrotherm::thermal {

using ThermalInputValues = Eigen::Vector<double, kThermalInputs>;

class FullTransient final {
 public:
  /// Starts at the field `start_c`. Call set() before the first step. `system` must outlive this. The change in each
  /// step is solved to a residual of `tolerance`.
  FullTransient(const ThermalSystem& system, Eigen::VectorXd start_c, double tolerance = 1e-7);

  /// Sets the length and the coefficients of the next steps. If only the coefficients change, the preconditioner is
  /// kept; the change must be small. Fails with numeric.
  [[nodiscard]] Result<void> set(double step_s, const ThermalCoefficients& c);
  /// Advances one step while the inputs change linearly: (C/h + K/2) T⁺ = (C/h − K/2) T + B (u + u⁺)/2. Conjugate
  /// gradients start at the extrapolation of the last step. Fails with numeric.
  [[nodiscard]] Result<void> step(const ThermalInputValues& from, const ThermalInputValues& to);
  /// Advances one step with a better starting point: an estimate of the change, °C.
  [[nodiscard]] Result<void> step(const ThermalInputValues& from, const ThermalInputValues& to,
                                  const Eigen::VectorXd& guess_c);
  /// Advances one step by two backward Euler half steps. Use it for the first step after a jump or a change of length:
  /// the trapezoidal rule would let the excited modes ring.
  [[nodiscard]] Result<void> damped_step(const ThermalInputValues& from, const ThermalInputValues& to);

  [[nodiscard]] const Eigen::VectorXd& field_c() const { return field_c_; }
  [[nodiscard]] Eigen::VectorXd outputs_c() const { return system_.outputs * field_c_; }
  [[nodiscard]] long iterations() const { return iterations_; }

 private:
  [[nodiscard]] Result<Eigen::VectorXd> solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess);
  [[nodiscard]] Eigen::VectorXd load(const ThermalInputValues& u) const;

  const ThermalSystem& system_;
  AffineMatrix matrices_;
  /// C/h + K/2.
  const SparseMatrix* matrix_ = nullptr;
  std::optional<ConjugateGradients> solver_;
  double tolerance_;
  double step_s_{};
  double film_{};
  Eigen::VectorXd field_c_;
  Eigen::VectorXd rate_c_per_s_;
  long iterations_ = 0;
};

struct ReductionTrial {
  GyroFilm film = GyroFilm::chamber;
  /// Temperature of the gap air for which the coefficients are computed. They stay constant.
  double air_c = 20;
  /// First step after a corner of the ramps; steps grow to 120 s.
  double shortest_s = 5;
  /// Includes the switch-on program.
  bool switch_on = true;
};

/// Runs the two programs. Ramps: the switched-on gyro rests at 20 °C; +5 °C/min to 60, 30 min there, −1 °C/min to −40,
/// 20 min there. Switch-on: the gyro rests at 20 °C, switched off; then all powers are switched on together for 1 h.
/// Both models use the trapezoidal rule on the same steps, damped at changes of length, so their difference is only due
/// to the reduction. Returns the largest differences over A…H after any step as ramp_k and switch_on_k. Fails with
/// numeric, like `solve`, or with interrupted.
[[nodiscard]] Result<ReductionError> measure(const ThermalSystem& system, const ReducedSystem& reduced,
                                             const ReductionTrial& trial, const SolveColumns& solve,
                                             const ProgressSink& progress = {});

}  // namespace gyrotherm::thermal
