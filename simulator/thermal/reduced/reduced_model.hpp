// SPDX-License-Identifier: Apache-2.0
/// The gyro's heat equation on few states, affine in the same coefficients as the full one (thermal_system.hpp):
///   dx/dt + (K₀ + Σ_m c_m K_m) x = (B₀ + Σ_m c_m B_m) u,   y = L x.
/// It is made once from the full model. Its file contains the hash of the full model's file and the measured error.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>

#include "core/random.hpp"
#include "core/result.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// Errors relative to the full model over A…H, K. Measured when the reduced model was made.
struct ReductionError {
  /// Largest error of any output at rest and at rates s > 0, at points that the reduction did not use.
  double transfer_k{};
  /// On the ramps of model_order_reduction_error.hpp.
  double ramp_k{};
  /// After all powers were switched on together.
  double switch_on_k{};
};

/// Air movement outside the cabinet: free convection on a bench, or the chamber's fan.
enum class GyroFilm { still, chamber };

struct ReducedModel {
  /// Name of the gyro file from which it was made, and the hash of that file's text.
  std::string gyro;
  std::string source_sha256;
  /// For example "medium, 308831 nodes".
  std::string mesh;
  CabinetAir air;
  /// Powers of a switched-on gyro.
  ThermalPowers powers_w{};
  /// Film coefficients for free convection on a bench and under the chamber's fan.
  double still_film_w_per_m2_k{};
  double chamber_film_w_per_m2_k{};
  /// K₀, r × r, symmetric.
  Eigen::MatrixXd conduction;
  std::array<Eigen::MatrixXd, kThermalCoefficients> conduction_per;
  Eigen::MatrixXd inputs;        ///< B₀, r × 6
  Eigen::VectorXd film_ambient;  ///< r
  Eigen::MatrixXd outputs;       ///< L, 18 × r
  ReductionError error;
};

/// Range of the gap air for which coefficients are computed. Outside it the value at the nearer end applies.
inline constexpr double kColdestGapAir_c = -80;
inline constexpr double kHottestGapAir_c = 130;

/// Returns the coefficients of the model's gaps with their air at `air_c`, and of the given film.
[[nodiscard]] ThermalCoefficients coefficients_at(const ReducedModel& model, double air_c, GyroFilm film);

/// Returns K(c), r × r, 1/s in the basis of the states.
[[nodiscard]] Eigen::MatrixXd conduction_at(const ReducedModel& model, const ThermalCoefficients& c);
/// Returns B(c), r × 6.
[[nodiscard]] Eigen::MatrixXd inputs_at(const ReducedModel& model, const ThermalCoefficients& c);
/// Returns (K(c) + s)⁻¹ B(c), r × 6: the response of the states to each input at the rate s, 1/s; at s = 0 the steady
/// state.
[[nodiscard]] Eigen::MatrixXd states_at(const ReducedModel& model, const ThermalCoefficients& c, double s);
/// Returns the inputs of a switched-on gyro: the ambient at `air_c` and the model's powers.
[[nodiscard]] Eigen::Vector<double, kThermalInputs> operating_inputs(const ReducedModel& model, double air_c);

/// Returns the model as text of schema "gyrotherm-reduced-gyro/1" (TOML). Reading it restores every bit.
[[nodiscard]] std::string reduced_model_text(const ReducedModel& model);
/// Reads a model. Fails with bad_file and reports every error with its position. Beyond TOML and schema it checks that
/// K(c) is positive definite from −60 to 80 °C under both films, that without power every output rests at the ambient
/// temperature, and that with the powers it rests within 200 K of it.
[[nodiscard]] Result<ReducedModel> parse_reduced_model(std::string_view text, const std::string& file);

// Draws one gyro of a type: the reduced model of another specimen, without recomputing the finite elements.

/// Standard deviations of the logarithms of log-normal factors with a median of 1.
struct ThermalSpread {
  /// One factor for all heat capacities.
  double capacity{};
  /// One factor for each air gap's conductivity and radiation.
  double gap{};
  /// One factor for both films.
  double film{};
  /// One factor for the gain arms, one for the preamplifier and one for the ballasts.
  double power{};
  /// One factor for the ratio of left to right gain-arm power, with a constant sum, and one for that of the ballasts.
  double arms{};
};

/// Returns a perturbed model. Always draws the same number of values from `random`, whatever the spread. Symmetric
/// positive definite matrices remain so. The left and right halves need not remain equal.
[[nodiscard]] ReducedModel perturb_model(const ReducedModel& model, const ThermalSpread& spread, RandomStream& random);

}  // namespace gyrotherm::thermal
