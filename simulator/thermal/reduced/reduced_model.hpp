// SPDX-License-Identifier: Apache-2.0
/// The gyro's heat equation on few states, affine in the same coefficients as the full one (thermal_system.hpp):
///   dx/dt + (K₀ + Σ_m c_m K_m) x = (B₀ + Σ_m c_m B_m) u,   y = L x.
/// Made once from the full model and kept as a file beside the gyro's, with the hash of what it was made from and its
/// measured error.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>

#include "core/random.hpp"
#include "core/result.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// Against the full model, measured when it was made; K, over A…H.
struct ReductionError {
  double transfer_k{};   ///< at rest and at s > 0 of points that the reduction did not use; every output
  double ramp_k{};       ///< on the ramps of model_order_reduction_error.hpp
  double switch_on_k{};  ///< after all powers came on at once
};

/// What moves the air outside the cabinet: free convection on a bench, or the chamber's fan.
enum class GyroFilm { still, chamber };

struct ReducedModel {
  std::string gyro;           ///< name of the gyro file it was made from
  std::string source_sha256;  ///< of that file's text
  std::string mesh;           ///< such as "medium, 308831 nodes"
  CabinetAir air;
  ThermalPowers powers_w{};          ///< gyro switched on
  double still_film_w_per_m2_k{};    ///< free convection on a bench
  double chamber_film_w_per_m2_k{};  ///< under the chamber's fan
  Eigen::MatrixXd conduction;        ///< K₀, r × r, symmetric
  std::array<Eigen::MatrixXd, kThermalCoefficients> conduction_per;
  Eigen::MatrixXd inputs;        ///< B₀, r × 6
  Eigen::VectorXd film_ambient;  ///< r
  Eigen::MatrixXd outputs;       ///< L, 18 × r
  ReductionError error;
};

/// Range of the air in the gaps for which coefficients are computed; beyond it they are those of its ends.
inline constexpr double kColdestGapAir_c = -80;
inline constexpr double kHottestGapAir_c = 130;

/// Of the model's gaps with their air at `air_c`, and of the film named.
[[nodiscard]] ThermalCoefficients coefficients_at(const ReducedModel& model, double air_c, GyroFilm film);

/// K(c), r × r, 1/s in the basis of the states.
[[nodiscard]] Eigen::MatrixXd conduction_at(const ReducedModel& model, const ThermalCoefficients& c);
/// B(c), r × 6.
[[nodiscard]] Eigen::MatrixXd inputs_at(const ReducedModel& model, const ThermalCoefficients& c);
/// (K(c) + s)⁻¹ B(c), r × 6: the states that answer each input at the rate s, 1/s; at s = 0 the rest.
[[nodiscard]] Eigen::MatrixXd states_at(const ReducedModel& model, const ThermalCoefficients& c, double s);
/// The ambient at `air_c` and the model's powers.
[[nodiscard]] Eigen::Vector<double, kThermalInputs> switched_on(const ReducedModel& model, double air_c);

/// Text of schema "gyrotherm-reduced-gyro/1" (TOML) and back; bit for bit.
[[nodiscard]] std::string reduced_model_text(const ReducedModel& model);
/// Fails with bad_file, every mistake with its place: beside what TOML and the schema ask, that K(c) is positive
/// definite from −60 to 80 °C under both films, that without power every output rests at the ambient, and with the
/// powers within 200 K of it.
[[nodiscard]] Result<ReducedModel> parse_reduced_model(std::string_view text, const std::string& file);

// Draws one gyro of a type: the reduced model of another specimen, without its finite elements.

/// Sigmas of ln of factors whose median is 1.
struct ThermalSpread {
  double capacity{};  ///< of all heat capacities together
  double gap{};       ///< of each air gap's conductivity, and of its radiation alike
  double film{};      ///< of both films together
  double power{};     ///< of each source: the gain arms together, the preamplifier, the ballasts together
  double arms{};      ///< of the left gain arm's power over the right's, their sum kept; likewise of the ballasts'
};

/// Always takes the same count of numbers from `random`, whatever the spread. Symmetric positive definite stays so;
/// left and right need no longer be alike.
[[nodiscard]] ReducedModel perturbed(const ReducedModel& model, const ThermalSpread& spread, RandomStream& random);

}  // namespace gyrotherm::thermal
