// SPDX-License-Identifier: Apache-2.0
/// Bodies small enough to be known exactly, and the shipped gyros.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/model_order_reduction.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// profiles/gyros/NAME.toml.
[[nodiscard]] std::string gyro_text(const std::string& name);
[[nodiscard]] GyroModel shipped_gyro(const std::string& name);

/// From 0 to `length` in equal pieces.
[[nodiscard]] std::vector<double> even_lines(double length, int pieces);

/// One box of one part, with film on the faces given (−x, +x, −y, +y, −z, +z).
[[nodiscard]] GyroMesh box_of(GyroPart part, std::vector<double> x, std::vector<double> y, std::vector<double> z,
                              const std::vector<int>& film_faces);

/// A model of nothing but materials: every one with these properties.
[[nodiscard]] GyroModel uniform_model(const MaterialProperties& properties);

/// K at given coefficients, film included, W/K, as a matrix.
[[nodiscard]] SparseMatrix conduction_matrix(const GyroModel& model, const GyroMesh& mesh,
                                             const ThermalCoefficients& coefficients);
/// Normal, of mean 0 and variance 1.
[[nodiscard]] Eigen::VectorXd random_vector(Eigen::Index size, unsigned seed);

// A gyro of 384 cells that takes milliseconds: a block with a warm side in a cabinet, air between them.

/// Finite volumes of 18 mm; alike left and right; the heat capacity has small numbers beside its diagonal.
[[nodiscard]] ThermalSystem box_gyro();

/// Names, air, films and powers of the box gyro; no matrices.
[[nodiscard]] ReducedModel about_box_gyro();

/// By factorisation.
[[nodiscard]] SolveColumns direct_solver();

/// box_gyro reduced to the goal of 1e-4 K, made once.
[[nodiscard]] const ReducedSystem& reduced_box_system();
[[nodiscard]] const ReducedModel& reduced_box_gyro();

}  // namespace gyrotherm::thermal
