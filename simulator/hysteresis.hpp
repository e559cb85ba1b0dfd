/// Two memories of a temperature: friction, and a control that leaps to the next mode when it is at its end.
#pragma once

#include <algorithm>
#include <cmath>

#include "simulator/bias_parameters.hpp"

namespace gyrotherm {

/// The play operator (Krasnosel'skii & Pokrovskii, Systems with Hysteresis, 1989, section 2): follows its input only
/// once that has moved by the half-width. Independent of rate: only turning points count.
class Play {
 public:
  /// `half_width_k` ≥ 0; starts midway.
  Play(double half_width_k, double input_c) : half_width_k_(half_width_k), output_c_(input_c) {}

  void follow(double input_c) {
    output_c_ = std::clamp(output_c_, input_c - half_width_k_, input_c + half_width_k_);
    lag_k_ = input_c - output_c_;
  }
  /// Input less output: between −half_width and half_width, positive after heating.
  [[nodiscard]] double lag_k() const { return lag_k_; }

 private:
  double half_width_k_;
  double output_c_;
  double lag_k_{};
};

/// The mode that the path-length control is locked to, as the light's path grows by one wavelength per
/// kelvin_per_mode: it stays until its actuator is at its end, then takes the mode nearest to the actuator's middle.
class ModeLock {
 public:
  /// Locked at `start_c` with its actuator in the middle.
  ModeLock(const ModeHops& hops, double start_c) : hops_(hops), start_c_(start_c) {}

  void follow(double path_c) {
    if (hops_.kelvin_per_mode == 0) return;
    const double wanted = (path_c - start_c_) / hops_.kelvin_per_mode;
    if (std::abs(wanted - mode_) > hops_.reach_modes) mode_ = std::round(wanted);
  }
  /// Whole wavelengths from where it started.
  [[nodiscard]] double mode() const { return mode_; }

 private:
  ModeHops hops_;
  double start_c_;
  double mode_{};
};

}  // namespace gyrotherm
