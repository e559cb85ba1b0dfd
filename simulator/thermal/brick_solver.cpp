// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/brick_solver.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

#include "simulator/thermal/brick_operator.hpp"
#include "simulator/thermal/conjugate_gradients.hpp"
#include "simulator/thermal/corner_level.hpp"

namespace gyrotherm::thermal {

struct BrickSolver::Parts {
  Parts(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients,
        const BrickSolverOptions& with);

  void weigh(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients);
  void smooth(bool leave_rest);
  void correct();
  void precondition(const Eigen::VectorXd& right, Eigen::VectorXd& answer);

  BrickSolverOptions options;
  BrickPlaces places;
  std::optional<BrickWeights<double>> weights;
  std::optional<BrickWeights<float>> rounded_weights;
  Eigen::VectorXf inverse;  ///< of the diagonal; 0 where there is no node
  std::optional<CornerLevel> corners;
  std::optional<ConjugateGradients> lower;
  Eigen::VectorXf rest, step, image, left;  ///< what the preconditioner works on
};

BrickSolver::Parts::Parts(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients,
                          const BrickSolverOptions& with)
    : options(with), places(mesh) {
  weigh(model, mesh, coefficients);
  corners.emplace(places, inverse);
  rest = step = image = left = Eigen::VectorXf::Zero(places.padded());
}

void BrickSolver::Parts::weigh(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients) {
  weights.emplace(model, mesh, places, coefficients);
  rounded_weights.emplace(model, mesh, places, coefficients);
  inverse = diagonal(places, *rounded_weights);
  for (auto& number : inverse) number = number > 0 ? 1 / number : 0;
}

/// left ← left + p(D⁻¹K) D⁻¹ rest with p of the degree that costs least in all, and, if asked for, the rest anew.
void BrickSolver::Parts::smooth(bool leave_rest) {
  constexpr int kDegree = 3;
  // No eigenvalue of D⁻¹K is above: the largest of D⁻¹K of any one brick, which is that of a brick that conducts in one
  // direction alone, 45° to its edges (8.51); 6.07 for one that conducts along its edges, 4.5 for a film.
  constexpr float kLargest = 8.6F;
  step.setZero();
  for (int i = 1; i <= kDegree; ++i) {
    const float keep = static_cast<float>(2 * i - 3) / static_cast<float>(2 * i + 1);
    const float take = static_cast<float>(8 * i - 4) / static_cast<float>(2 * i + 1) / kLargest;
    step = keep * step + take * inverse.cwiseProduct(rest);
    left += step;
    if (i == kDegree && !leave_rest) return;
    multiply(places, *rounded_weights, step.data(), image.data());
    rest -= image;
  }
}

/// left ← left + P v, v one V-cycle's answer to Pᵀ rest, and the rest anew.
void BrickSolver::Parts::correct() {
  corners->up(places, lower->precondition(corners->down(places, rest)), step);
  left += step;
  multiply(places, *rounded_weights, step.data(), image.data());
  rest -= image;
}

/// Symmetric to rounding, and the same whatever the scale of `right`.
void BrickSolver::Parts::precondition(const Eigen::VectorXd& right, Eigen::VectorXd& answer) {
  const double scale = right.cwiseAbs().maxCoeff();
  assert(scale > 0);
  rest = (right / scale).cast<float>();
  left.setZero();
  smooth(true);
  correct();
  smooth(false);
  answer = scale * left.cast<double>();
}

BrickSolver::BrickSolver(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
BrickSolver::~BrickSolver() = default;
BrickSolver::BrickSolver(BrickSolver&&) noexcept = default;
BrickSolver& BrickSolver::operator=(BrickSolver&&) noexcept = default;

Result<BrickSolver> BrickSolver::set_up(const GyroModel& model, const GyroMesh& mesh,
                                        const ThermalCoefficients& coefficients, const BrickSolverOptions& options) {
  auto parts = std::make_unique<Parts>(model, mesh, coefficients, options);
  auto lower = ConjugateGradients::set_up(parts->corners->matrix(parts->places, *parts->weights));
  if (!lower) return failure(lower.error());
  parts->lower = std::move(*lower);
  return BrickSolver(std::move(parts));
}

void BrickSolver::replace(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients) {
  parts_->weigh(model, mesh, coefficients);
}

auto BrickSolver::solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess) -> Result<Solution> {
  auto& p = *parts_;
  Eigen::VectorXd x = p.places.from_nodes(guess);
  Eigen::VectorXd rest = p.places.from_nodes(right);
  const double whole = rest.norm();
  const double goal = p.options.tolerance * whole;
  Eigen::VectorXd image(p.places.padded());
  multiply(p.places, *p.weights, x.data(), image.data());
  rest -= image;
  Eigen::VectorXd answer;
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(p.places.padded());
  Solution solution;
  double last = 0;
  double size = rest.norm();
  for (; size > goal && solution.iterations < p.options.most_iterations; ++solution.iterations) {
    p.precondition(rest, answer);
    const double now = rest.dot(answer);
    direction = answer + (solution.iterations == 0 ? 0 : now / last) * direction;
    last = now;
    multiply(p.places, *p.weights, direction.data(), image.data());
    const double along = now / direction.dot(image);
    x += along * direction;
    rest -= along * image;
    size = rest.norm();
  }
  solution.relative_residual = whole > 0 ? size / whole : size;
  if (!(size <= goal)) {
    return failure(FaultKind::numeric, "conjugate gradients",
                   fmt::format("relative residual {:.1e} after {} iterations, expected at most {:.1e}",
                               solution.relative_residual, solution.iterations, p.options.tolerance));
  }
  solution.x = p.places.to_nodes(x);
  return solution;
}

}  // namespace gyrotherm::thermal
