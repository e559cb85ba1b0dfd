// SPDX-License-Identifier: Apache-2.0
/// From a gyro file's model to its reduced model: mesh, matrices, reduction, errors measured on the same mesh.
#pragma once

#include <string>

#include "core/result.hpp"
#include "thermal/gyro_model.hpp"
#include "thermal/mesh.hpp"
#include "thermal/model_order_reduction.hpp"

namespace gyrotherm::thermal {

/// By conjugate gradients with algebraic multigrid, set up once per matrix.
[[nodiscard]] SolveColumns multigrid_solver();

/// What a reduced model says beside its matrices.
[[nodiscard]] ReducedModel about(const GyroModel& gyro, const std::string& source_sha256);

/// The medium mesh takes about two minutes and 2 GB. Fails as reduce() and measure() do.
[[nodiscard]] Result<ReducedModel> reduce_gyro(const GyroModel& gyro, const std::string& source_sha256, MeshSize mesh,
                                               const ReductionOptions& options, const ProgressSink& progress = {});

}  // namespace gyrotherm::thermal
