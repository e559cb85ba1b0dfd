/// The full heat equation → few states that answer alike, at every coefficient of air from −60 to 80 °C under both
/// films, and of gaps that all conduct alike, as the worst of them does from cold to heat and up to 0.06 W/(m·K) at
/// least.
///
/// Rational Krylov fields (K(c) + s C)⁻¹ B(c), one-sided projection (A. C. Antoulas, Approximation of Large-Scale
/// Dynamical Systems, ch. 11): symmetry stays, so the small system is stable. Where to solve is chosen step by step:
/// the coefficients, the rate and the inputs at which the fields found so far answer worst. What is found is then
/// compressed by proper orthogonal decomposition over a dense grid of answers, those to the inputs and those of the
/// outputs' adjoints, in the norm of the heat capacity.
#pragma once

#include <functional>

#include "core/progress.hpp"
#include "core/result.hpp"
#include "simulator/thermal/reduced_model.hpp"

namespace gyrotherm {

/// Residual over right-hand side at which a solution will do: what is solved for is what an answer still misses, of
/// which five digits are more than enough.
inline constexpr double kSolved = 1e-5;

/// Solves A X = R, A symmetric positive definite, one column after another, to kSolved or better.
using SolveColumns = std::function<Result<Eigen::MatrixXd>(const SparseMatrix& matrix, const Eigen::MatrixXd& right)>;

struct ReductionOptions {
  int states = 56;       ///< at most
  int most_fields = 76;  ///< to solve for before the compression
  double goal_k = 5e-3;  ///< largest error of an output, for 50 K of ambient or the powers
};

/// `about` says what the model is of: names, air, films, powers; its matrices and its error are not read. The model's
/// transfer_k is set, measured at coefficients and rates that took no part; the other errors are reduction_error.hpp's.
/// Fails with numeric (goal not met: the figure, the place), as `solve` does, or with interrupted.
[[nodiscard]] Result<ReducedModel> reduce(const ThermalSystem& system, const ReducedModel& about,
                                          const ReductionOptions& options, const SolveColumns& solve,
                                          const ProgressSink& progress = {});

/// Magnitudes at which inputs are judged: 50 K, and each power or, of a source that is weak or off, a tenth of them
/// all.
[[nodiscard]] Eigen::Vector<double, kThermalInputs> usual_inputs(const ReducedModel& about);

}  // namespace gyrotherm
