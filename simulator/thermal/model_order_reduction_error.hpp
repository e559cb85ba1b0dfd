// SPDX-License-Identifier: Apache-2.0
/// How far a reduced model is from the full one in time: the two programs of its file's [error].
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
  /// Starts at the field `start_c`; set() must come before the first step. `system` must outlive this. A step's change
  /// is solved for to a residual of `tolerance`.
  FullTransient(const ThermalSystem& system, Eigen::VectorXd start_c, double tolerance = 1e-7);

  /// Length of the steps to come and the coefficients that hold for them. Where only these change, and little, the
  /// preconditioner stays. Fails with numeric.
  [[nodiscard]] Result<void> set(double step_s, const ThermalCoefficients& c);
  /// One step while the inputs go linearly from one to the other: (C/h + K/2) T⁺ = (C/h − K/2) T + B (u + u⁺)/2.
  /// Conjugate gradients start where the last step points to. Fails with numeric.
  [[nodiscard]] Result<void> step(const ThermalInputValues& from, const ThermalInputValues& to);
  /// The same with a better start: a guess of the change, °C.
  [[nodiscard]] Result<void> step(const ThermalInputValues& from, const ThermalInputValues& to,
                                  const Eigen::VectorXd& guess_c);
  /// The same by two backward Euler halves, which damp what a jump or a longer step has excited and the trapezoidal
  /// rule would let ring: for the step after one.
  [[nodiscard]] Result<void> damped_step(const ThermalInputValues& from, const ThermalInputValues& to);

  [[nodiscard]] const Eigen::VectorXd& field_c() const { return field_c_; }
  [[nodiscard]] Eigen::VectorXd outputs_c() const { return system_.outputs * field_c_; }
  [[nodiscard]] long iterations() const { return iterations_; }  ///< of all steps

 private:
  [[nodiscard]] Result<Eigen::VectorXd> solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess);
  [[nodiscard]] Eigen::VectorXd load(const ThermalInputValues& u) const;

  const ThermalSystem& system_;
  AffineMatrix matrices_;
  const SparseMatrix* matrix_ = nullptr;  ///< C/h + K/2
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
  double air_c = 20;      ///< coefficients are those of the gaps at this temperature, throughout
  double shortest_s = 5;  ///< step after a corner of the ramps; they grow to 120 s
  bool switch_on = true;  ///< off: only the ramps
};

/// Ramps: the gyro, on, rests at 20 °C; +5 °C/min to 60, 30 min there, −1 °C/min to −40, 20 min there. Switch-on: it
/// rests at 20 °C, off; all powers at once, 1 h. Both models by the trapezoidal rule on the same steps,
/// damped where their length changes, so that what
/// differs is the reduction alone; largest difference over A…H after any step. Sets ramp_k and switch_on_k.
/// Fails with numeric, as `solve` does, or with interrupted.
[[nodiscard]] Result<ReductionError> measure(const ThermalSystem& system, const ReducedSystem& reduced,
                                             const ReductionTrial& trial, const SolveColumns& solve,
                                             const ProgressSink& progress = {});

}  // namespace gyrotherm::thermal
