// SPDX-License-Identifier: Apache-2.0
/// The gyro's heat equation after discretisation, affine in the coefficients that depend on temperature and on the air
/// around the cabinet:
///   C dT/dt + (K₀ + Σ_m c_m K_m) T = (B₀ + Σ_m c_m B_m) u,   y = L T,   T in °C.
/// Adding a constant to u's ambient and to every T changes no other number: K_m·1 = B_m's ambient column.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <string_view>

namespace gyrotherm::thermal {

/// c_m: effective conductivity of the cabinet's three air gaps, W/(m·K), and film on the cabinet's outside, W/(m²·K).
enum class ThermalCoefficient : std::size_t { air_lid, air_side, air_base, film };
inline constexpr std::size_t kThermalCoefficients = 4;
using ThermalCoefficients = std::array<double, kThermalCoefficients>;

/// u: chamber air in °C, then watts.
enum class ThermalInput : std::size_t { ambient, gain_left, gain_right, preamplifier, ballast_left, ballast_right };
inline constexpr std::size_t kThermalInputs = 6;
inline constexpr std::array<std::string_view, kThermalInputs> kThermalInputNames{
    "ambient", "gain_left", "gain_right", "preamplifier", "ballast_left", "ballast_right"};
/// W, of the inputs after the ambient.
using ThermalPowers = std::array<double, kThermalInputs - 1>;

/// The power of an input that is not the ambient.
[[nodiscard]] inline double& power_of(ThermalPowers& powers_w, ThermalInput input) {
  return powers_w[static_cast<std::size_t>(input) - 1];
}

/// y, °C: the thermometers' places A…H, points on the block's top face; then means over volumes. Mirrors are named by
/// the thermometer in their corner, left is the side of B, D and F.
enum class ThermalOutput : std::size_t {
  a,
  b,
  c,
  d,
  e,
  f,
  g,
  h,
  shell,
  gain_left,
  gain_right,
  passive_bore,
  preamplifier,
  mirror_b,
  mirror_c,
  mirror_f,
  mirror_h,
  block
};
inline constexpr std::size_t kThermalOutputs = 18;
inline constexpr std::array<std::string_view, kThermalOutputs> kThermalOutputNames{
    {"A", "B", "C", "D", "E", "F", "G", "H", "shell", "gain_left", "gain_right", "passive_bore", "preamplifier",
     "mirror_b", "mirror_c", "mirror_f", "mirror_h", "block"}};

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

struct ThermalSystem {
  SparseMatrix capacity;                                          ///< C, J/K; both triangles
  SparseMatrix conduction;                                        ///< K₀, W/K; both triangles
  std::array<SparseMatrix, kThermalCoefficients> conduction_per;  ///< K_m per unit of c_m, same pattern rules
  Eigen::MatrixXd inputs;        ///< B₀, n × 6: per watt; the ambient's column is zero, its way in is the film
  Eigen::VectorXd film_ambient;  ///< the ambient's column of B_film; every other column of every B_m is zero
  SparseMatrix outputs;          ///< L, 18 × n; each row sums to 1
};

/// One gap, between the block (or what stands on it) and the cabinet's wall.
struct AirGap {
  double nusselt = 1;   ///< heat carried over heat conducted
  double emissivity{};  ///< effective, of the two faces
  double width_m{};
};

struct CabinetAir {
  AirGap lid, side, base;
};

/// The three gaps at `air_c`, and the outside's film as given.
[[nodiscard]] ThermalCoefficients coefficients_at(const CabinetAir& air, double air_c, double film_w_per_m2_k);

}  // namespace gyrotherm::thermal
