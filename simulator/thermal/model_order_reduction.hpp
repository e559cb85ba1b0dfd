// SPDX-License-Identifier: Apache-2.0
/// Reduces the full heat equation to one with few states and nearly equal responses. The reduced model is valid under
/// both films, for the air coefficients at all temperatures from −60 to 80 °C. It is also valid if all gaps have the
/// same conductivity. This conductivity may range from the lowest one of any gap at −60 °C up to 0.06 W/(m·K), or up to
/// the lowest one of any gap at 80 °C if that is larger.
///
/// The basis consists of rational Krylov fields (K(c) + s C)⁻¹ B(c) with one-sided projection (A. C. Antoulas,
/// Approximation of Large-Scale Dynamical Systems, ch. 11): symmetry is kept, so the small system is stable. The points
/// to solve are chosen greedily: the coefficients, rate and inputs with the largest error of the present basis. The
/// basis is then compressed by proper orthogonal decomposition over a dense grid of responses at imaginary rates, to
/// the inputs and to the outputs' adjoints, in the norm of the heat capacity.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/hex20.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/reduced/reduced_model.hpp"

namespace gyrotherm::thermal {

/// A point at which a response is computed: (K(c) + s C) X = B(c).
struct ThermalPoint {
  ThermalCoefficients coefficients{};
  /// s ≥ 0; 0 is the steady state.
  double rate_per_s{};
};

class ReducedBasis final {
 public:
  /// Starts with the constant field, so a model without power rests exactly at the ambient temperature. `weights` scale
  /// the residual of each unknown (a diagonal preconditioner, W). `header` provides all data of the model except its
  /// matrices.
  ReducedBasis(const ThermalSystem& system, ReducedModel header, const Eigen::VectorXd& weights,
               Eigen::Index most_states);

  /// Makes the fields orthonormal and adds the independent ones. Returns their number.
  Eigen::Index grow(Eigen::MatrixXd fields);

  /// Returns an estimate, within some per cent, of sqrt(rᵀ W r) for each column u of `loads` (inputs × columns), where
  /// r is the residual B u − (K + s C) V x. The residual is sketched by random signs into few sums (Charikar, Chen &
  /// Farach-Colton 2004; for reduced bases Balabanov & Nouy 2019), so the cost depends on the number of states and not
  /// on the number of unknowns.
  [[nodiscard]] Eigen::VectorXd residuals(const ThermalPoint& point, const Eigen::MatrixXd& loads) const;

  [[nodiscard]] const ReducedModel& model() const { return model_; }
  [[nodiscard]] auto basis() const { return basis_.leftCols(states_); }

 private:
  /// Number of full matrices, in the order C, K₀, K_m.
  static constexpr std::size_t kParts = 2 + kThermalCoefficients;
  [[nodiscard]] const SparseMatrix& part(std::size_t index) const;
  [[nodiscard]] Eigen::VectorXd sketch(const Eigen::VectorXd& residual) const;
  [[nodiscard]] bool append(Eigen::VectorXd field);
  void project(Eigen::Index from);

  const ThermalSystem& system_;
  /// Square roots with random signs.
  Eigen::VectorXd weights_;
  /// Index of the sketch sum of each unknown.
  std::vector<int> sums_;
  /// Sized for the largest number of states.
  Eigen::MatrixXd basis_;
  Eigen::Index states_ = 0;
  ReducedModel model_;
  std::array<Eigen::MatrixXd, kParts> sketched_parts_;
  Eigen::MatrixXd sketched_inputs_;
  Eigen::VectorXd sketched_film_;
};

/// Largest ratio of residual to right-hand side in a solution. A solution only corrects the present response, so four
/// digits suffice.
inline constexpr double kSolveTolerance = 1e-4;

/// Solves A X = R with a symmetric positive definite A, column by column, to kSolveTolerance or better.
using SolveColumns = std::function<Result<Eigen::MatrixXd>(const SparseMatrix& matrix, const Eigen::MatrixXd& right)>;

struct ReductionOptions {
  /// Greatest number of states of the reduced model.
  int states = 84;
  /// Greatest number of temperature fields that are solved before the compression.
  int most_fields = 200;
  /// Largest permitted error of an output for an ambient of 50 K, or for the powers.
  double goal_k = 5e-3;
};

struct ReducedSystem {
  ReducedModel model;
  /// V, n × r, with VᵀCV = I. The field of a state x is V x.
  Eigen::MatrixXd basis;
};

/// Reduces a system. `header` provides names, air, films and powers; its matrices and error are ignored. Sets the
/// model's transfer_k, measured at coefficients and rates that the reduction did not use; measure() computes the other
/// errors. Fails with numeric if the goal is not met (with error and point), like `solve`, or with interrupted.
[[nodiscard]] Result<ReducedSystem> reduce(const ThermalSystem& system, const ReducedModel& header,
                                           const ReductionOptions& options, const SolveColumns& solve,
                                           const ProgressSink& progress = {});

/// Returns the loads for which the errors of responses are compared, 6 × 6, one per column: 100 K of ambient; the
/// powers of both gain arms, of the preamplifier and of both ballasts; and the powers of the arms, and of the ballasts,
/// with opposite signs. The power of a weak source is raised to a tenth of the total power.
[[nodiscard]] Eigen::Matrix<double, kThermalInputs, kThermalInputs> reference_loads(const ReducedModel& header);

// Converts a gyro file's model to its reduced model: mesh, matrices, reduction, errors measured on the same mesh.

/// Returns a solver by conjugate gradients with algebraic multigrid, set up once per matrix.
[[nodiscard]] SolveColumns multigrid_solver();

/// Returns the data of a reduced model except its matrices.
[[nodiscard]] ReducedModel make_header(const GyroModel& gyro, const std::string& source_sha256);

/// Reduces a gyro. The medium mesh takes about two minutes and 2 GB. Fails like reduce() and measure().
[[nodiscard]] Result<ReducedModel> reduce_gyro(const GyroModel& gyro, const std::string& source_sha256, MeshSize mesh,
                                               const ReductionOptions& options, const ProgressSink& progress = {});

}  // namespace gyrotherm::thermal
