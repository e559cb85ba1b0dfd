// SPDX-License-Identifier: Apache-2.0
/// Computes a ring laser gyro's bias from the temperatures inside it: one contribution per physical source. The sources
/// depend on the gain arms, the mirrors and the block's mean, which no thermometer measures.
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

/// Flow of the gas in the two discharge arms along the light's path. The two flows oppose each other.
struct GasFlow {
  /// Bias shift per unbalance of the flows.
  double shift_deg_per_h_per_cm_per_s{};
  /// Velocity in each arm at 20 °C and nominal current.
  double velocity_cm_per_s{};
  /// Exponent of the arm's absolute temperature, from the viscosity of the gas.
  double exponent{};
  /// Relative unbalance of the arms' currents and bores: (left − right) / mean.
  double unbalance{};
  /// Change of the unbalance per kelvin of the current controller's temperature above 20 °C.
  double unbalance_per_k{};
};

/// One periodic contribution of the mirrors' backscatter. Its phase follows the length of the light's path.
struct BackscatterWave {
  double deg_per_h{};
  /// Temperature change of the light's path for one period.
  double period_k{};
  double phase_deg{};
};

/// One play operator: friction between parts that expand differently.
struct HysteresisPlay {
  double half_width_k{};
  /// Contribution to the bias after the temperature rose by more than half_width_k. After an equal fall the
  /// contribution has the opposite sign.
  double deg_per_h{};
};

/// Steps of the path-length control from one longitudinal mode to the next. Disabled if kelvin_per_mode is 0.
struct ModeHops {
  /// Change of the path's temperature that lengthens the path by one wavelength.
  double kelvin_per_mode{};
  /// Range of the actuator to either side.
  double reach_modes{};
  /// Step of the bias per mode.
  double step_deg_per_h{};
  /// Distance of the path from the nearest mode at 20 °C, in wavelengths, −½ … ½. If empty, the actuator starts in the
  /// middle of its range.
  std::optional<double> phase_modes{};
  /// Range of the duration of a hop, drawn for each hop. 0: a hop is instantaneous.
  double shortest_s{}, longest_s{};
  /// Added at the beginning of a hop; decays to 0 at its end.
  double transient_deg_per_h{};
};

/// Change of coefficients with the block's mean temperature T̄: each is multiplied by 1 + γ (T̄ − 20 °C)/40 K. A model
/// that is linear in thermometer readings cannot represent this; it needs products of its inputs.
struct CoefficientGrowth {
  double gas_flow{};
  std::array<double, 4> mirrors{};
  double backscatter{};
};

/// First-order lag of a contribution behind its input, caused by an adhesive, a mirror or the gas, for which the
/// thermal model has no node. `share` is the part of the contribution that lags; a share of 0 switches the lag off.
struct HiddenLag {
  double share{};                ///< 0 … 1
  double time_constant_s = 600;  ///< 1 or more
};

/// One exponential of the glass-ceramic's structural relaxation. The length of the material depends on temperature and
/// on time (Zerodur: Jedamzik et al., Proc. SPIE 7739, 2010): a change of temperature immediately adds a term, which
/// then decays.
struct Relaxation {
  double time_constant_s{};
  /// Per kelvin of the block's mean above the temperature to which the material has relaxed.
  double deg_per_h_per_k{};
};

/// One exponential of the warm-up.
struct WarmUp {
  double time_constant_s{};
  /// Value in the first second.
  double deg_per_h{};
};

/// Lags of gas flow and deformation behind the temperatures of the thermal model.
struct HiddenLags {
  HiddenLag gas_flow, deformation;
};

struct BiasPhysics {
  GasFlow flow;
  /// Per kelvin of mirrors B, C, F and H above the block's mean.
  std::array<double, 4> mirror_deg_per_h_per_k{};
  /// Coefficients of the polynomial in the block's mean temperature minus 20 °C.
  double linear_deg_per_h_per_k{};
  double quadratic_deg_per_h_per_k2{};
  std::vector<BackscatterWave> waves;
  std::vector<HysteresisPlay> plays;
  ModeHops mode_hops;
  CoefficientGrowth growth{};
  HiddenLags lags{};
  std::vector<Relaxation> relaxations{};
  std::vector<WarmUp> warm_up{};
};

/// History of a gyro before a run begins.
struct GyroHistory {
  /// Turning points of the block's temperature, the oldest first. If empty, the block has rested at its start
  /// temperature.
  std::vector<double> turning_points_c{};
  /// Seed of all values that each run draws independently.
  std::uint64_t run{};
};

/// The play operator (Krasnosel'skii & Pokrovskii, Systems with Hysteresis, 1989, section 2). Its output follows the
/// input only after the input has moved by the half-width. The output does not depend on the rate of change, only on
/// the turning points of the input.
class Play {
 public:
  /// Starts in the middle of the play. `half_width_k` must be ≥ 0.
  Play(double half_width_k, double input_c) : half_width_k_(half_width_k), output_c_(input_c) {}

  void follow(double input_c) {
    output_c_ = std::clamp(output_c_, input_c - half_width_k_, input_c + half_width_k_);
    lag_k_ = input_c - output_c_;
  }
  /// Returns input minus output: between −half_width and half_width, positive after heating.
  [[nodiscard]] double lag_k() const { return lag_k_; }

 private:
  double half_width_k_;
  double output_c_;
  double lag_k_{};
};

/// The mode to which the path-length control is locked. The light's path grows by one wavelength per kelvin_per_mode.
/// The mode remains until the actuator reaches the end of its range; then it changes to the mode nearest to the
/// actuator's middle. During a hop the bias moves on a straight line from its value at the beginning to that of the new
/// mode, and a transient decays.
class ModeLock {
 public:
  /// Starts locked to the mode nearest at `start_c`.
  ModeLock(const ModeHops& hops, double start_c, RandomStream random = {0, RandomPurpose::mode_hops});

  /// Advances by one second to the path temperature `path_c`.
  void follow(double path_c);
  /// Returns the number of modes between the present mode and the mode at the start (or, with a phase, the mode nearest
  /// at 20 °C).
  [[nodiscard]] double mode() const { return mode_; }
  [[nodiscard]] bool is_hopping() const { return passed_s_ < transient_s_; }
  [[nodiscard]] double deg_per_h() const;

 private:
  /// Returns the part of the hop that remains, from 1 to 0.
  [[nodiscard]] double remaining_share() const;
  /// Returns the position between two modes on the line of a hop, otherwise the mode.
  [[nodiscard]] double path_mode() const;

  ModeHops hops_;
  double zero_c_;
  /// Mode, and the position at which the last hop began.
  double mode_{}, before_{};
  /// Time since the last hop began, and its duration.
  double passed_s_{}, transient_s_{};
  RandomStream random_;
};

/// Returns the share of a difference that a first-order lag closes in a second. The time constant must be above 0.
[[nodiscard]] double closing_share(double time_constant_s);

/// A contribution to the bias with a first-order lag. Exact if the input is constant during each second.
class LaggingPart {
 public:
  explicit LaggingPart(const HiddenLag& lag);

  /// Advances by one second with the contribution `now`. Returns (1 − share) now + share · lagged. The first call
  /// starts at rest.
  double follow(double now);

 private:
  HiddenLag lag_;
  double closing_share_;
  double lagged_{};
  bool began_ = false;
};

/// The sum Σ d_i (x − z_i), where dz_i/dt = (x − z_i)/τ_i. It is zero at rest and Σ d_i per kelvin immediately after a
/// jump of x. Exact if x is constant during each second.
class RelaxingBias {
 public:
  /// Starts at rest at `start_c`.
  RelaxingBias(const std::vector<Relaxation>& terms, double start_c);

  void follow(double now_c);
  [[nodiscard]] double deg_per_h() const { return deg_per_h_; }

 private:
  struct Term {
    double deg_per_h_per_k, closing_share, relaxed_c;
  };
  std::vector<Term> terms_;
  double deg_per_h_{};
};

/// °C, in the order of ThermalOutput.
using InnerTemperatures = std::span<const double, thermal::kThermalOutputs>;

/// Returns the bias from Langmuir flow. In each arm the discharge drives the gas along the light at v₀ (T/293.15 K)^p,
/// where T is the arm's temperature. The flows of the two arms oppose each other, and their difference drags the light
/// (Aronowitz & Lim, Opt. Eng. 18, 1979): k {(1 + u/2) v_left − (1 − u/2) v_right}. A difference of 1 K between the
/// arms at 20 °C changes the bias by k v₀ p / 293.15.
[[nodiscard]] double gas_flow_deg_per_h(const GasFlow& flow, double left_c, double right_c);

/// Returns k v u'. v is the mean gas velocity of the two arms. u' is the unbalance per kelvin, multiplied by the excess
/// over 20 °C of the temperature of the electronics that control the currents.
[[nodiscard]] double electronics_deg_per_h(const GasFlow& flow, InnerTemperatures inner_c);

/// Returns Σ_m g_m (1 + γ_m (T_block − 20 °C)/40 K) (T_m − T_block) over the mirrors. An unevenly expanded cavity
/// affects the two beams differently.
[[nodiscard]] double deformation_deg_per_h(const BiasPhysics& physics, InnerTemperatures inner_c);

/// Returns k₁ x + k₂ x², where x is the block's mean temperature minus 20 °C.
[[nodiscard]] double temperature_deg_per_h(const BiasPhysics& physics, double block_c);

/// Returns Σ u sin(2π x/period + phase), where x is the path's temperature minus 20 °C.
[[nodiscard]] double backscatter_deg_per_h(const std::vector<BackscatterWave>& waves, double path_c);

/// Returns Σ a_i exp(−t/τ_i), where t is the time since the gyro was switched on. Three terms represent the phases of a
/// ring laser's warm-up: discharge, cavity and cabinet.
[[nodiscard]] double warm_up_deg_per_h(const std::vector<WarmUp>& phases, double seconds_on);

/// Contributions to the bias, °/h each. The bias is their sum.
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

/// The sum of all contributions, with the state of hysteresis, mode hops and slow effects.
class GyroBias {
 public:
  /// Starts at switch-on: at rest at `start_c` after the history `past`, and locked to the nearest mode.
  GyroBias(const BiasPhysics& physics, InnerTemperatures start_c, const GyroHistory& past = {});

  /// Advances by one second to these temperatures.
  void step(InnerTemperatures now_c);
  /// Restarts the warm-up: the gyro is switched on again.
  void restart() { seconds_on_ = 0; }

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
