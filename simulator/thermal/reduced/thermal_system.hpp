// SPDX-License-Identifier: Apache-2.0
/// The gyro's discretised heat equation, affine in the coefficients that depend on temperature and on the air around
/// the cabinet:
///   C dT/dt + (K₀ + Σ_m c_m K_m) T = (B₀ + Σ_m c_m B_m) u,   y = L T,   T in °C.
/// Adding a constant to the ambient in u and to every T leaves dT/dt unchanged, because K_m·1 equals the ambient column
/// of B_m.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <string_view>

namespace gyrotherm::thermal {

/// Coefficients c_m: effective conductivity of the cabinet's three air gaps, W/(m·K), and film on the cabinet's
/// outside, W/(m²·K).
enum class ThermalCoefficient : std::size_t { air_lid, air_side, air_base, film };
inline constexpr std::size_t kThermalCoefficients = 4;
using ThermalCoefficients = std::array<double, kThermalCoefficients>;

/// Inputs u: chamber air in °C, then powers in W.
enum class ThermalInput : std::size_t { ambient, gain_left, gain_right, preamplifier, ballast_left, ballast_right };
inline constexpr std::size_t kThermalInputs = 6;
inline constexpr std::array<std::string_view, kThermalInputs> kThermalInputNames{
    "ambient", "gain_left", "gain_right", "preamplifier", "ballast_left", "ballast_right"};
/// Powers in W: the inputs after the ambient.
using ThermalPowers = std::array<double, kThermalInputs - 1>;

/// Returns the power of an input other than the ambient.
[[nodiscard]] inline double& input_power(ThermalPowers& powers_w, ThermalInput input) {
  return powers_w[static_cast<std::size_t>(input) - 1];
}

/// Outputs y, °C: the thermometer locations A…H, points on the block's top face; then means over volumes. A mirror has
/// the name of the thermometer in its corner. Left is the side of B, D and F.
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
  /// C in J/K and K₀ in W/K, with both triangles.
  SparseMatrix capacity;
  SparseMatrix conduction;
  /// K_m per unit of c_m, with both triangles.
  std::array<SparseMatrix, kThermalCoefficients> conduction_per;
  /// B₀, n × 6, per watt. The ambient column is zero; the ambient enters through the film.
  Eigen::MatrixXd inputs;
  /// Ambient column of B_film. All other columns of all B_m are zero.
  Eigen::VectorXd film_ambient;
  /// L, 18 × n; each row sums to 1.
  SparseMatrix outputs;
};

/// One gap, between the block (or a part on it) and the cabinet's wall.
struct AirGap {
  /// Nusselt number: transported heat divided by conducted heat.
  double nusselt = 1;
  /// Effective emissivity of the two faces.
  double emissivity{};
  double width_m{};
};

struct CabinetAir {
  AirGap lid, side, base;
};

/// Returns the coefficients of the three gaps at `air_c`, with the given film outside.
[[nodiscard]] ThermalCoefficients coefficients_at(const CabinetAir& air, double air_c, double film_w_per_m2_k);

}  // namespace gyrotherm::thermal
