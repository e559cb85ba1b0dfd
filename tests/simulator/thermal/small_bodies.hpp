// SPDX-License-Identifier: Apache-2.0
/// Small bodies with exact or fast solutions, and the shipped gyros.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/model_order_reduction.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// Returns the text and the model of profiles/gyros/NAME.toml.
[[nodiscard]] std::string gyro_text(const std::string& name);
[[nodiscard]] GyroModel shipped_gyro(const std::string& name);

/// Returns lines from 0 to `length` in equal pieces.
[[nodiscard]] std::vector<double> even_lines(double length, int pieces);

/// Returns a box of one part, with film on the given faces (−x, +x, −y, +y, −z, +z).
[[nodiscard]] GyroMesh box_of(GyroPart part, std::vector<double> x, std::vector<double> y, std::vector<double> z,
                              const std::vector<int>& film_faces);

/// Returns a model with these properties for each material.
[[nodiscard]] GyroModel uniform_model(const MaterialProperties& properties);

/// Returns the matrix K, including the film, for the given coefficients, W/K.
[[nodiscard]] SparseMatrix conduction_matrix(const GyroModel& model, const GyroMesh& mesh,
                                             const ThermalCoefficients& coefficients);
/// Returns normally distributed numbers of mean 0 and variance 1.
[[nodiscard]] Eigen::VectorXd random_vector(Eigen::Index size, unsigned seed);

// The box gyro has 384 cells and is solved within milliseconds: a block with a warm side in a cabinet, with air between
// them.

/// Returns the finite-volume model of the box gyro with cells of 18 mm. Left and right are equal. The heat capacity has
/// small off-diagonal elements.
[[nodiscard]] ThermalSystem box_gyro();

/// Returns a model of the box gyro without matrices: names, air, films and powers.
[[nodiscard]] ReducedModel box_gyro_description();

/// Returns a solver by factorisation.
[[nodiscard]] SolveColumns direct_solver();

/// Return the box gyro reduced to an error of 1e-4 K. It is reduced only once per process.
[[nodiscard]] const ReducedSystem& reduced_box_system();
[[nodiscard]] const ReducedModel& reduced_box_gyro();

}  // namespace gyrotherm::thermal
