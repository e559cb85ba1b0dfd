// SPDX-License-Identifier: Apache-2.0
/// Contributions to the bias that time makes: what comes late, what a ramp leaves, what relaxes, what warms up. Each
/// follows its input exactly where that stands still for a second.
#pragma once

#include <vector>

namespace gyrotherm::simulator {

/// The share of a difference that a first-order lag of this time constant, > 0, closes in a second.
[[nodiscard]] double closes_in_a_second(double time_constant_s);

/// A share of a contribution that comes through a first-order lag: an adhesive, a mirror, the gas, which no node of the
/// thermal model shows. Off while `share` is 0.
struct HiddenLag {
  double share{};                ///< 0 … 1
  double time_constant_s = 600;  ///< 1 or more
};

/// One exponential of the glass-ceramic's structural relaxation. Its length depends on temperature and on time
/// (Zerodur: Jedamzik et al., Proc. SPIE 7739, 2010): what a change of temperature adds at once dies away.
struct Relaxation {
  double time_constant_s{};
  double deg_per_h_per_k{};  ///< of the block's mean above what the material has relaxed to
};

/// One exponential of the warm-up.
struct WarmUp {
  double time_constant_s{};
  double deg_per_h{};  ///< in the first second
};

/// A contribution with its lag.
class LaggingPart {
 public:
  explicit LaggingPart(const HiddenLag& lag);

  /// One second on, the contribution is `now`: returns (1 − share) now + share · lagged. The first call is at rest.
  double follow(double now);

 private:
  HiddenLag lag_;
  double closes_;  ///< share of the difference that a second closes
  double lagged_{};
  bool began_ = false;
};

/// Σ d_i (x − z_i), dz_i/dt = (x − z_i)/τ_i: zero at rest, d per kelvin just after a jump of x.
class RelaxingBias {
 public:
  /// At rest at `start_c`.
  RelaxingBias(const std::vector<Relaxation>& terms, double start_c);

  void follow(double now_c);
  [[nodiscard]] double deg_per_h() const { return deg_per_h_; }

 private:
  struct Term {
    double deg_per_h_per_k, closes, relaxed_c;
  };
  std::vector<Term> terms_;
  double deg_per_h_{};
};

/// Σ a_i exp(−t/τ_i), t since the gyro was switched on: three of them are the phases of a ring laser's warm-up, the
/// discharge, the cavity and the cabinet.
[[nodiscard]] double warm_up_deg_per_h(const std::vector<WarmUp>& phases, double seconds_on);

}  // namespace gyrotherm::simulator
