// SPDX-License-Identifier: Apache-2.0
/// The full heat equation → few states that answer alike, at every coefficient of air from −60 to 80 °C under both
/// films, and of gaps that all conduct alike, as the worst of them does from cold to heat and up to 0.06 W/(m·K) at
/// least.
///
/// Rational Krylov fields (K(c) + s C)⁻¹ B(c), one-sided projection (A. C. Antoulas, Approximation of Large-Scale
/// Dynamical Systems, ch. 11): symmetry stays, so the small system is stable. Where to solve is chosen step by step:
/// the coefficients, the rate and the inputs at which the fields found so far answer worst. What is found is then
/// compressed by proper orthogonal decomposition over a dense grid of answers at imaginary rates, those to the inputs
/// and those of the outputs' adjoints, in the norm of the heat capacity.
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

/// Where an answer is asked for: (K(c) + s C) X = B(c).
struct ThermalPoint {
  ThermalCoefficients coefficients{};
  double rate_per_s{};  ///< s ≥ 0; 0 is the rest
};

class ReducedBasis final {
 public:
  /// Begins with the constant field, so that a model without power rests at the ambient exactly. `weights` scale the
  /// residual of each unknown (a diagonal preconditioner's, W). `about` gives the projection all that is no matrix.
  ReducedBasis(const ThermalSystem& system, ReducedModel about, Eigen::VectorXd weights, Eigen::Index most_states);

  /// Makes the fields orthonormal and takes what is new of them; returns how many that were.
  Eigen::Index grow(Eigen::MatrixXd fields);

  /// Estimate, within some per cent, of sqrt(rᵀ W r) for each column u of `loads` (inputs × columns), r the residual
  /// B u − (K + s C) V x: it is sketched by random signs into few sums (Charikar, Chen & Farach-Colton 2004; for
  /// reduced bases Balabanov & Nouy 2019), so that an estimate costs as the states do and not as the unknowns.
  [[nodiscard]] Eigen::VectorXd residuals(const ThermalPoint& point, const Eigen::MatrixXd& loads) const;

  [[nodiscard]] const ReducedModel& model() const { return model_; }
  [[nodiscard]] auto basis() const { return basis_.leftCols(states_); }

 private:
  /// The full matrices in the order C, K₀, K_m.
  static constexpr std::size_t kParts = 2 + kThermalCoefficients;
  [[nodiscard]] const SparseMatrix& part(std::size_t index) const;
  [[nodiscard]] Eigen::VectorXd sketch(const Eigen::VectorXd& residual) const;
  [[nodiscard]] bool append(Eigen::VectorXd field);
  void project(Eigen::Index from);

  const ThermalSystem& system_;
  Eigen::VectorXd weights_;  ///< square roots, with random signs
  std::vector<int> sums_;    ///< which sum of the sketch each unknown goes to
  Eigen::MatrixXd basis_;    ///< room for all states
  Eigen::Index states_ = 0;
  ReducedModel model_;
  std::array<Eigen::MatrixXd, kParts> sketched_parts_;
  Eigen::MatrixXd sketched_inputs_;
  Eigen::VectorXd sketched_film_;
};

/// Residual over right-hand side at which a solution will do: what is solved for is what an answer still misses, of
/// which four digits are enough.
inline constexpr double kSolved = 1e-4;

/// Solves A X = R, A symmetric positive definite, one column after another, to kSolved or better.
using SolveColumns = std::function<Result<Eigen::MatrixXd>(const SparseMatrix& matrix, const Eigen::MatrixXd& right)>;

struct ReductionOptions {
  int states = 84;        ///< at most
  int most_fields = 200;  ///< to solve for before the compression
  double goal_k = 5e-3;   ///< largest error of an output, for 50 K of ambient or the powers
};

struct ReducedSystem {
  ReducedModel model;
  Eigen::MatrixXd basis;  ///< V, n × r, VᵀCV = I: a state's field is V x
};

/// `about` says what the model is of: names, air, films, powers; its matrices and its error are not read. The model's
/// transfer_k is set, measured at coefficients and rates that took no part; measure() makes the other errors.
/// Fails with numeric (goal not met: the figure, the place), as `solve` does, or with interrupted.
[[nodiscard]] Result<ReducedSystem> reduce(const ThermalSystem& system, const ReducedModel& about,
                                           const ReductionOptions& options, const SolveColumns& solve,
                                           const ProgressSink& progress = {});

/// What the answers are judged by, 6 × 6, one load per column: 100 K of ambient; the powers of both gain arms, of the
/// preamplifier, of both ballasts; and those of the arms, and of the ballasts, one up and the other down. A source that
/// is weak or off counts with a tenth of all.
[[nodiscard]] Eigen::Matrix<double, kThermalInputs, kThermalInputs> usual_loads(const ReducedModel& about);

// From a gyro file's model to its reduced model: mesh, matrices, reduction, errors measured on the same mesh.

/// By conjugate gradients with algebraic multigrid, set up once per matrix.
[[nodiscard]] SolveColumns multigrid_solver();

/// What a reduced model says beside its matrices.
[[nodiscard]] ReducedModel about(const GyroModel& gyro, const std::string& source_sha256);

/// The medium mesh takes about two minutes and 2 GB. Fails as reduce() and measure() do.
[[nodiscard]] Result<ReducedModel> reduce_gyro(const GyroModel& gyro, const std::string& source_sha256, MeshSize mesh,
                                               const ReductionOptions& options, const ProgressSink& progress = {});

}  // namespace gyrotherm::thermal
