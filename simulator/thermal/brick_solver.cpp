// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/brick_solver.hpp"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "simulator/thermal/conjugate_gradients.hpp"
#include "simulator/thermal/hex20.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr int kCorners = 8;
using CornerMatrix = Eigen::Matrix<double, kCorners, kCorners>;
using Interpolation = Eigen::Matrix<double, kHex20, kCorners>;

/// Returns P of one brick.
Interpolation from_corners() {
  Interpolation interpolation;
  for (int n = 0; n < kHex20; ++n) {
    for (int c = 0; c < kCorners; ++c) {
      double share = 1;
      for (int d = 0; d < 3; ++d) {
        const int apart = std::abs(kHex20Positions[n][d] - kHex20Positions[c][d]);
        share *= 1 - 0.5 * apart;
      }
      interpolation(n, c) = share;
    }
  }
  return interpolation;
}

/// Returns the index of corner `to` among the 27 around corner `from`, which is in the middle; x runs fastest.
int neighbour_index(int from, int to) {
  const auto step = [&](int d) { return (kHex20Positions[to][d] - kHex20Positions[from][d]) / 2 + 1; };
  return step(0) + 3 * step(1) + 9 * step(2);
}

/// Matrix rows of the corners: the entries for the 27 corners around each.
using Stencils = std::vector<std::array<double, 27>>;

void add_bricks(const FieldLayout& layout, const BrickWeights<double>& weights, Stencils& stencils) {
  const auto p = from_corners();
  const auto& r = hex20_integrals();
  std::array<CornerMatrix, 3> slopes;
  for (std::size_t d = 0; d < 3; ++d) slopes[d] = p.transpose() * r.slopes[d] * p;
  const CornerMatrix cross = p.transpose() * r.cross * p;
  each_weighted_brick(layout, weights, [&](int i, int j, int k, std::size_t at) {
    if (weights.x[at] == 0 && weights.z[at] == 0) return;
    CornerMatrix matrix = weights.x[at] * slopes[0] + weights.y[at] * slopes[1] + weights.z[at] * slopes[2];
    if (weights.xy[at] != 0) matrix += weights.xy[at] * cross;
    for (int n = 0; n < kCorners; ++n) {
      auto& stencil = stencils[static_cast<std::size_t>(layout.node_position(i, j, k, n))];
      for (int m = 0; m < kCorners; ++m) stencil[neighbour_index(n, m)] += matrix(n, m);
    }
  });
}

void add_film(const BrickWeights<double>& weights, Stencils& stencils) {
  const auto p = from_corners();
  std::array<CornerMatrix, kBrickFaces> faces;
  for (int face = 0; face < kBrickFaces; ++face) faces[face] = p.transpose() * hex20_integrals().face_mass[face] * p;
  for (const auto& face : weights.film) {
    const auto nodes = face_nodes(face.face);
    for (std::size_t n = 0; n < 4; ++n)
      for (std::size_t m = 0; m < 4; ++m)
        stencils[static_cast<std::size_t>(face.positions[n])][neighbour_index(nodes[n], nodes[m])] +=
            face.film * faces[face.face](nodes[n], nodes[m]);
  }
}

/// Calls visit(middle, end, other end) with the positions of every edge of the grid.
template <class Visit>
void each_edge(const FieldLayout& layout, Visit visit) {
  for (int k = 0; k <= layout.nz(); ++k) {
    for (int j = 0; j <= layout.ny(); ++j) {
      for (int i = 0; i < layout.nx(); ++i)
        visit(layout.x_edge(i, j, k), layout.corner(i, j, k), layout.corner(i + 1, j, k));
      for (int i = 0; i <= layout.nx() && j < layout.ny(); ++i)
        visit(layout.y_edge(i, j, k), layout.corner(i, j, k), layout.corner(i, j + 1, k));
      for (int i = 0; i <= layout.nx() && k < layout.nz(); ++i)
        visit(layout.z_edge(i, j, k), layout.corner(i, j, k), layout.corner(i, j, k + 1));
    }
  }
}

}  // namespace

CornerLevel::CornerLevel(const FieldLayout& layout, const Eigen::VectorXf& diagonal) {
  number_.assign(static_cast<std::size_t>(layout.corners()), -1);
  has_node_.resize(static_cast<std::size_t>(layout.count()));
  for (Eigen::Index position = 0; position < layout.count(); ++position) {
    has_node_[static_cast<std::size_t>(position)] = diagonal[position] > 0;
    if (position >= layout.corners() || !(diagonal[position] > 0)) continue;
    number_[static_cast<std::size_t>(position)] = static_cast<std::int32_t>(position_.size());
    position_.push_back(static_cast<std::int32_t>(position));
  }
}

SparseMatrix CornerLevel::matrix(const FieldLayout& layout, const BrickWeights<double>& weights) const {
  Stencils stencils(number_.size());
  add_bricks(layout, weights, stencils);
  add_film(weights, stencils);
  const auto rows = static_cast<Eigen::Index>(position_.size());
  SparseMatrix matrix(rows, rows);
  matrix.reserve(27 * rows);
  const auto along_y = layout.corner(0, 1, 0);
  const auto along_z = layout.corner(0, 0, 1);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto here = position_[static_cast<std::size_t>(row)];
    matrix.startVec(row);
    const auto& stencil = stencils[static_cast<std::size_t>(here)];
    for (int o = 0; o < 27; ++o) {
      if (stencil[o] == 0) continue;
      const auto there = here + (o % 3 - 1) + (o / 3 % 3 - 1) * along_y + (o / 9 - 1) * along_z;
      matrix.insertBack(row, number_[static_cast<std::size_t>(there)]) = stencil[o];
    }
  }
  matrix.finalize();
  return matrix;
}

Eigen::VectorXd CornerLevel::restrict_to_corners(const FieldLayout& layout, const Eigen::VectorXf& field) const {
  Eigen::VectorXf sums = field.head(layout.corners());
  each_edge(layout, [&](Eigen::Index middle, Eigen::Index end, Eigen::Index other) {
    const float half = 0.5F * field[middle];
    sums[end] += half;
    sums[other] += half;
  });
  Eigen::VectorXd corners(static_cast<Eigen::Index>(position_.size()));
  for (std::size_t c = 0; c < position_.size(); ++c) corners[static_cast<Eigen::Index>(c)] = sums[position_[c]];
  return corners;
}

void CornerLevel::prolongate(const FieldLayout& layout, const Eigen::VectorXd& corners, Eigen::VectorXf& field) const {
  field.setZero();
  for (std::size_t c = 0; c < position_.size(); ++c)
    field[position_[c]] = static_cast<float>(corners[static_cast<Eigen::Index>(c)]);
  each_edge(layout, [&](Eigen::Index middle, Eigen::Index end, Eigen::Index other) {
    if (has_node_[static_cast<std::size_t>(middle)]) field[middle] = 0.5F * (field[end] + field[other]);
  });
}

struct BrickSolver::Parts {
  Parts(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients,
        const BrickSolverOptions& with);

  void update_weights(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients);
  void smooth(bool update_residual);
  void correct();
  void precondition(const Eigen::VectorXd& right, Eigen::VectorXd& answer);

  BrickSolverOptions options;
  FieldLayout layout;
  std::optional<BrickWeights<double>> weights;
  std::optional<BrickWeights<float>> rounded_weights;
  /// Inverse diagonal; 0 at positions without a node.
  Eigen::VectorXf inverse;
  std::optional<CornerLevel> corners;
  std::optional<ConjugateGradients> lower;
  /// Work vectors of the preconditioner.
  Eigen::VectorXf rest, step, image, left;
};

BrickSolver::Parts::Parts(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients,
                          const BrickSolverOptions& with)
    : options(with), layout(mesh) {
  update_weights(model, mesh, coefficients);
  corners.emplace(layout, inverse);
  rest = step = image = left = Eigen::VectorXf::Zero(layout.padded_size());
}

void BrickSolver::Parts::update_weights(const GyroModel& model, const GyroMesh& mesh,
                                        const ThermalCoefficients& coefficients) {
  weights.emplace(model, mesh, layout, coefficients);
  rounded_weights.emplace(model, mesh, layout, coefficients);
  inverse = diagonal(layout, *rounded_weights);
  for (auto& number : inverse) number = number > 0 ? 1 / number : 0;
}

/// Computes left ← left + p(D⁻¹K) D⁻¹ rest, with p of the degree of lowest total cost, and updates the residual `rest`
/// if `update_residual`.
void BrickSolver::Parts::smooth(bool update_residual) {
  constexpr int kDegree = 3;
  // Upper bound of the eigenvalues of D⁻¹K: the largest of D⁻¹K of any single brick. It occurs for a brick that
  // conducts only in one direction, at 45° to its edges (8.51). It is 6.07 for a brick that conducts along its edges
  // and 4.5 for a film.
  constexpr float kLargest = 8.6F;
  step.setZero();
  for (int i = 1; i <= kDegree; ++i) {
    const float keep = static_cast<float>(2 * i - 3) / static_cast<float>(2 * i + 1);
    const float take = static_cast<float>(8 * i - 4) / static_cast<float>(2 * i + 1) / kLargest;
    step = keep * step + take * inverse.cwiseProduct(rest);
    left += step;
    if (i == kDegree && !update_residual) return;
    multiply(layout, *rounded_weights, step.data(), image.data());
    rest -= image;
  }
}

/// Computes left ← left + P v, v the result of one V-cycle for Pᵀ rest, and updates the residual `rest`.
void BrickSolver::Parts::correct() {
  corners->prolongate(layout, lower->precondition(corners->restrict_to_corners(layout, rest)), step);
  left += step;
  multiply(layout, *rounded_weights, step.data(), image.data());
  rest -= image;
}

/// Applies the preconditioner. Symmetric up to rounding and independent of the scale of `right`.
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

Result<BrickSolver> BrickSolver::create(const GyroModel& model, const GyroMesh& mesh,
                                        const ThermalCoefficients& coefficients, const BrickSolverOptions& options) {
  auto parts = std::make_unique<Parts>(model, mesh, coefficients, options);
  auto lower = ConjugateGradients::create(parts->corners->matrix(parts->layout, *parts->weights));
  if (!lower) return failure(lower.error());
  parts->lower = std::move(*lower);
  return BrickSolver(std::move(parts));
}

void BrickSolver::replace(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients) {
  parts_->update_weights(model, mesh, coefficients);
}

auto BrickSolver::solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess) -> Result<Solution> {
  auto& p = *parts_;
  Eigen::VectorXd x = p.layout.from_nodes(guess);
  Eigen::VectorXd rest = p.layout.from_nodes(right);
  const double initial_norm = rest.norm();
  const double goal = p.options.tolerance * initial_norm;
  Eigen::VectorXd image(p.layout.padded_size());
  multiply(p.layout, *p.weights, x.data(), image.data());
  rest -= image;
  Eigen::VectorXd answer;
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(p.layout.padded_size());
  Solution solution;
  double last = 0;
  double size = rest.norm();
  for (; size > goal && solution.iterations < p.options.most_iterations; ++solution.iterations) {
    p.precondition(rest, answer);
    const double now = rest.dot(answer);
    direction = answer + (solution.iterations == 0 ? 0 : now / last) * direction;
    last = now;
    multiply(p.layout, *p.weights, direction.data(), image.data());
    const double along = now / direction.dot(image);
    x += along * direction;
    rest -= along * image;
    size = rest.norm();
  }
  solution.relative_residual = initial_norm > 0 ? size / initial_norm : size;
  if (!(size <= goal)) {
    return failure(FaultKind::numeric, "conjugate gradients",
                   fmt::format("relative residual {:.1e} after {} iterations, expected at most {:.1e}",
                               solution.relative_residual, solution.iterations, p.options.tolerance));
  }
  solution.x = p.layout.to_nodes(x);
  return solution;
}

}  // namespace gyrotherm::thermal
