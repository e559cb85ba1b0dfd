// SPDX-License-Identifier: Apache-2.0
#include "thermal/gyro_reduction.hpp"

#include <fmt/format.h>

#include "thermal/assembly.hpp"
#include "thermal/conjugate_gradients.hpp"
#include "thermal/model_order_reduction_error.hpp"

namespace gyrotherm::thermal {

SolveColumns multigrid_solver() {
  return [](const SparseMatrix& matrix, const Eigen::MatrixXd& right) -> Result<Eigen::MatrixXd> {
    auto solver = ConjugateGradients::set_up(matrix, {.tolerance = kSolved});
    if (!solver) return failure(solver.error());
    Eigen::MatrixXd solutions(right.rows(), right.cols());
    for (Eigen::Index i = 0; i < right.cols(); ++i) {
      auto solution = solver->solve(right.col(i));
      if (!solution) return failure(solution.error());
      solutions.col(i) = std::move(solution->x);
    }
    return solutions;
  };
}

ReducedModel about(const GyroModel& gyro, const std::string& source_sha256) {
  ReducedModel model;
  model.gyro = gyro.name;
  model.source_sha256 = source_sha256;
  model.air = gyro.air;
  model.powers_w = gyro.powers_w;
  model.still_film_w_per_m2_k = gyro.still_film_w_per_m2_k;
  model.chamber_film_w_per_m2_k = gyro.chamber_film_w_per_m2_k;
  return model;
}

Result<ReducedModel> reduce_gyro(const GyroModel& gyro, const std::string& source_sha256, MeshSize size,
                                 const ReductionOptions& options, const ProgressSink& progress) {
  const auto mesh = make_mesh(gyro, size);
  const auto system = assemble(gyro, mesh);
  auto what = about(gyro, source_sha256);
  what.mesh = fmt::format("{}, {} nodes", kMeshSizeNames[static_cast<std::size_t>(size)], mesh.node_count);
  const auto solve = multigrid_solver();
  auto reduced = reduce(system, what, options, solve, progress);
  if (!reduced) return failure(reduced.error());
  const auto error = measure(system, *reduced, {}, solve, progress);
  if (!error) return failure(error.error());
  reduced->model.error = *error;
  return std::move(reduced->model);
}

}  // namespace gyrotherm::thermal
