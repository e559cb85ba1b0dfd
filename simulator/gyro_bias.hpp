// SPDX-License-Identifier: Apache-2.0
/// What the temperatures inside a ring laser gyro make of its bias: one contribution per physical source, each fed by
/// the gain arms, the mirrors and the block's mean, which no thermometer shows.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/quantity.hpp"
#include "core/random.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::simulator {

/// Flow of the gas in the two discharge arms, against each other along the light's path.
struct GasFlow {
  double shift_deg_per_h_per_cm_per_s{};  ///< of the bias per unbalance of the flows
  double velocity_cm_per_s{};             ///< in each arm at 20 °C and nominal current
  double exponent{};                      ///< of the arm's absolute temperature: that of the gas' viscosity
  double unbalance{};                     ///< relative, of the arms' currents and bores: (left − right) / mean
  double unbalance_per_k{};               ///< its change with the current control's temperature, above 20 °C
};

/// One periodic contribution of the mirrors' backscatter, whose phase follows the length of the light's path.
struct BackscatterWave {
  double deg_per_h{};
  double period_k{};  ///< of the path's temperature
  double phase_deg{};
};

/// One play operator: friction between parts that expand differently.
struct HysteresisPlay {
  double half_width_k{};
  double deg_per_h{};  ///< while the temperature rises beyond the half-width; the opposite while it falls
};

/// Steps of the path-length control from one longitudinal mode to the next. Off while kelvin_per_mode is 0.
struct ModeHops {
  double kelvin_per_mode{};             ///< of the path's temperature, for one wavelength of its length
  double reach_modes{};                 ///< what the actuator can follow, to either side
  double step_deg_per_h{};              ///< of the bias, per mode
  std::optional<double> phase_modes{};  ///< wavelengths from a mode at 20 °C, −½ … ½; nothing: the actuator starts in
                                        ///< its middle, wherever that is
  double shortest_s{}, longest_s{};  ///< a hop takes so long, drawn anew for each; 0: it is done at once
  double transient_deg_per_h{};      ///< added when it begins, gone when it is done
};

/// How coefficients change with the block's mean: each is multiplied by 1 + γ (T̄ − 20 °C)/40 K. The thermometers see
/// none of it without products of inputs.
struct CoefficientGrowth {
  double gas_flow{};
  std::array<double, 4> mirrors{};
  double backscatter{};
};

/// The share of a contribution that follows its input through a first-order lag: an adhesive, a mirror or the gas, for
/// which the thermal model has no node. A `share` of 0 switches the lag off.
struct HiddenLag {
  double share{};                ///< 0 … 1
  double time_constant_s = 600;  ///< 1 or more
};

/// One exponential of the glass-ceramic's structural relaxation. Its length depends on temperature and on time
/// (Zerodur: Jedamzik et al., Proc. SPIE 7739, 2010): a change of temperature adds a term at once, which decays.
struct Relaxation {
  double time_constant_s{};
  double deg_per_h_per_k{};  ///< of the block's mean above what the material has relaxed to
};

/// One exponential of the warm-up.
struct WarmUp {
  double time_constant_s{};
  double deg_per_h{};  ///< in the first second
};

/// Lags of gas flow and deformation behind the temperatures of the thermal model.
struct HiddenLags {
  HiddenLag gas_flow, deformation;
};

struct BiasPhysics {
  GasFlow flow;
  std::array<double, 4> mirror_deg_per_h_per_k{};  ///< of mirrors B, C, F, H above the block's mean
  double linear_deg_per_h_per_k{};                 ///< of the block's mean above 20 °C
  double quadratic_deg_per_h_per_k2{};
  std::vector<BackscatterWave> waves;
  std::vector<HysteresisPlay> plays;
  ModeHops mode_hops;
  CoefficientGrowth growth{};
  HiddenLags lags{};
  std::vector<Relaxation> relaxations{};
  std::vector<WarmUp> warm_up{};
};

/// What a gyro has been through before a run begins.
struct GyroPast {
  std::vector<double> turning_points_c{};  ///< of its block, the oldest first; empty: it has rested where it starts
  std::uint64_t run{};                     ///< draws what each run draws anew
};

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
/// While a hop lasts the bias goes from one mode's to the next one's by a straight line, and a transient dies away.
class ModeLock {
 public:
  /// Locked at `start_c` to the nearest mode.
  ModeLock(const ModeHops& hops, double start_c, RandomStream random = {0, RandomPurpose::mode_hops});

  /// A second passes, and the path has come here.
  void follow(double path_c);
  /// Whole wavelengths from the mode at the start (or, with a phase, from the one nearest at 20 °C).
  [[nodiscard]] double mode() const { return mode_; }
  [[nodiscard]] bool is_hopping() const { return passed_s_ < transient_s_; }
  [[nodiscard]] double deg_per_h() const;

 private:
  ModeHops hops_;
  double zero_c_;
  double mode_{}, before_{};
  double passed_s_{}, transient_s_{};  ///< of the last hop
  RandomStream random_;
};

/// Returns the share of a difference that a first-order lag closes in a second. The time constant must be above 0.
[[nodiscard]] double closes_in_a_second(double time_constant_s);

/// A contribution with its lag. Exact for an input that is constant for a second.
class LaggingPart {
 public:
  explicit LaggingPart(const HiddenLag& lag);

  /// Advances by one second to the contribution `now`. Returns (1 − share) now + share · lagged. The first call starts
  /// at rest.
  double follow(double now);

 private:
  HiddenLag lag_;
  double closes_;  ///< share of the difference that a second closes
  double lagged_{};
  bool began_ = false;
};

/// Σ d_i (x − z_i), dz_i/dt = (x − z_i)/τ_i: zero at rest, d per kelvin just after a jump of x. Exact for an x that is
/// constant for a second.
class RelaxingBias {
 public:
  /// Starts at rest at `start_c`.
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

using InnerTemperatures = std::span<const double, thermal::kThermalOutputs>;  ///< °C, in the order of ThermalOutput

/// Langmuir flow: in each arm the discharge drives the gas along the light, at v₀ (T/293.15 K)^p, T the arm's; the two
/// arms oppose each other, and what is left drags the light (Aronowitz & Lim, Opt. Eng. 18, 1979): k {(1 + u/2) v_left
/// − (1 − u/2) v_right}. An arm warmer by 1 K at 20 °C is worth k v₀ p / 293.15.
[[nodiscard]] double gas_flow_deg_per_h(const GasFlow& flow, double left_c, double right_c);

/// k v u', v the mean of the two arms' and u' the unbalance per kelvin times the temperature, above 20 °C, of the
/// electronics that control the arms' currents.
[[nodiscard]] double electronics_deg_per_h(const GasFlow& flow, InnerTemperatures inner_c);

/// Σ_m g_m (1 + γ_m (T_block − 20 °C)/40 K) (T_m − T_block) over the mirrors: a cavity that expands unevenly is not the
/// same for both beams.
[[nodiscard]] double deformation_deg_per_h(const BiasPhysics& physics, InnerTemperatures inner_c);

/// k₁ x + k₂ x², x the block's mean less 20 °C.
[[nodiscard]] double temperature_deg_per_h(const BiasPhysics& physics, double block_c);

/// Σ u sin(2π x/period + phase), x the path's temperature less 20 °C.
[[nodiscard]] double backscatter_deg_per_h(const std::vector<BackscatterWave>& waves, double path_c);

/// Returns Σ a_i exp(−t/τ_i), t since the gyro was switched on. Three terms are the phases of a ring laser's warm-up:
/// the discharge, the cavity and the cabinet.
[[nodiscard]] double warm_up_deg_per_h(const std::vector<WarmUp>& phases, double seconds_on);

/// °/h each; the bias is their sum.
struct BiasParts {
  double gas_flow{};
  double deformation{};
  double temperature{};
  double backscatter{};
  double hysteresis{};
  double mode_hops{};
  double electronics{};
  double relaxation{};
  double warm_up{};
};

/// The contributions together, with the memory that hysteresis, mode hops and all that is slow need.
class GyroBias {
 public:
  /// At rest after its past; the mode is the one that was locked there, and the gyro has just been switched on.
  GyroBias(const BiasPhysics& physics, InnerTemperatures start_c, const GyroPast& past = {});

  /// A second has passed, and the temperatures have come here.
  void step(InnerTemperatures now_c);
  /// It is switched on again now.
  void start_anew() { seconds_on_ = 0; }

  [[nodiscard]] const BiasParts& parts() const { return parts_; }
  [[nodiscard]] DegreesPerHour total() const;

 private:
  void follow(InnerTemperatures now_c);

  BiasPhysics physics_;
  std::vector<Play> plays_;
  ModeLock lock_;
  LaggingPart flow_, deformation_;
  RelaxingBias relaxing_;
  double seconds_on_{};
  BiasParts parts_;
};

}  // namespace gyrotherm::simulator
