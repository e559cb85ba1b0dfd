// SPDX-License-Identifier: Apache-2.0
/// Compares the matrix-free product with the assembled matrix, and tests the solver based on it.
#include "simulator/thermal/brick_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "simulator/thermal/brick_operator.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr ThermalCoefficients kCoefficients{0.05, 0.02, 0.035, 12};

struct Body {
  std::string name;
  GyroModel model;
  GyroMesh mesh;
};

/// Returns bodies with slanted bricks, with empty ones, and with rows of 1, 16 and 17 bricks.
std::vector<Body> bodies() {
  std::vector<Body> all;
  const auto full = shipped_gyro("fast-film");
  all.push_back({"full", full, make_mesh(full, 9.0)});
  auto block = shipped_gyro("calibrated");
  block.mode = GyroMode::block;
  all.push_back({"block", block, make_mesh(block, 9.0)});
  for (const int bricks : {1, 16, 17})
    all.push_back({"box of " + std::to_string(bricks), uniform_model({2000, 500, 1.5}),
                   box_of(GyroPart::block, even_lines(0.1, bricks), {0, 0.01, 0.03}, even_lines(0.05, 3), {0, 3, 4})});
  return all;
}

template <class Real>
Eigen::VectorXd product(const Body& body, const Eigen::VectorXd& field) {
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  const FieldLayout layout(body.mesh);
  const BrickWeights<Real> weights(body.model, body.mesh, layout, kCoefficients);
  const Vector placed = layout.from_nodes(field).template cast<Real>();
  Vector result(layout.padded_size());
  multiply(layout, weights, placed.data(), result.data());
  return layout.to_nodes(result.template cast<double>());
}

TEST(BrickOperator, EqualsAssembledMatrix) {
  for (const auto& body : bodies()) {
    const auto matrix = conduction_matrix(body.model, body.mesh, kCoefficients);
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const auto field = random_vector(matrix.rows(), seed);
      const Eigen::VectorXd expected = matrix * field;
      EXPECT_LT((product<double>(body, field) - expected).norm(), 1e-14 * expected.norm()) << body.name << ' ' << seed;
      EXPECT_LT((product<float>(body, field) - expected).norm(), 1e-5 * expected.norm()) << body.name << ' ' << seed;
    }
    const FieldLayout layout(body.mesh);
    const BrickWeights<double> weights(body.model, body.mesh, layout, kCoefficients);
    const auto own = diagonal(layout, weights);
    EXPECT_LT((layout.to_nodes(own) - matrix.diagonal()).norm(), 1e-14 * matrix.diagonal().norm()) << body.name;
    EXPECT_NEAR(own.sum() / matrix.diagonal().sum(), 1, 1e-12) << body.name << ": 0 at positions without a node";
  }
}

/// No eigenvalue of K may exceed the upper bound that the smoother assumes. Power iteration from a random field
/// approaches the largest eigenvalue from below.
TEST(BrickOperator, HasNoEigenvalueAboveSmootherBound) {
  for (const auto& body : bodies()) {
    const auto matrix = conduction_matrix(body.model, body.mesh, kCoefficients);
    Eigen::VectorXd field = random_vector(matrix.rows(), 1);
    double largest = 0;
    for (int i = 0; i < 60; ++i) {
      field = (matrix * field).cwiseQuotient(matrix.diagonal()).eval();
      largest = field.norm();
      field /= largest;
    }
    EXPECT_LT(largest, 8.6) << body.name;
    EXPECT_GT(largest, 3) << body.name;
  }
}

/// uᵀ (Pᵀ K P) v = (P u)ᵀ K (P v).
TEST(CornerLevel, HasEnergyOfInterpolatedField) {
  for (const auto& body : bodies()) {
    const FieldLayout layout(body.mesh);
    const BrickWeights<double> weights(body.model, body.mesh, layout, kCoefficients);
    const CornerLevel level(layout, diagonal(layout, weights).cast<float>());
    const auto matrix = level.matrix(layout, weights);
    const Eigen::VectorXd u = random_vector(matrix.rows(), 1).cast<float>().cast<double>();
    const Eigen::VectorXd v = random_vector(matrix.rows(), 2).cast<float>().cast<double>();
    Eigen::VectorXf up_u(layout.padded_size());
    Eigen::VectorXf up_v(layout.padded_size());
    level.prolongate(layout, u, up_u);
    level.prolongate(layout, v, up_v);
    Eigen::VectorXd image(layout.padded_size());
    multiply(layout, weights, Eigen::VectorXd(up_v.cast<double>()).data(), image.data());
    const double scale = std::sqrt(u.dot(matrix * u) * v.dot(matrix * v));
    EXPECT_NEAR(up_u.cast<double>().dot(image), u.dot(matrix * v), 1e-6 * scale) << body.name;
    const auto down = level.restrict_to_corners(layout, image.cast<float>());
    EXPECT_NEAR(u.dot(down), up_u.cast<double>().dot(image), 1e-5 * u.norm() * down.norm()) << body.name;
  }
}

TEST(BrickSolver, ConvergesInTensOfSteps) {
  for (const auto& body : bodies()) {
    const auto matrix = conduction_matrix(body.model, body.mesh, kCoefficients);
    auto solver = BrickSolver::create(body.model, body.mesh, kCoefficients, {.tolerance = 1e-10});
    ASSERT_TRUE(solver) << text(solver.error());
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const auto right = random_vector(matrix.rows(), seed);
      const auto solution = solver->solve(right, Eigen::VectorXd::Zero(right.size()));
      ASSERT_TRUE(solution) << body.name << ": " << text(solution.error());
      EXPECT_LT((matrix * solution->x - right).norm(), 1.1e-10 * right.norm()) << body.name << ' ' << seed;
      EXPECT_LT(solution->iterations, 50) << body.name << ' ' << seed;
    }
  }
}

class Solved : public testing::Test {
 protected:
  void SetUp() override {
    auto made = BrickSolver::create(body_.model, body_.mesh, kCoefficients);
    ASSERT_TRUE(made) << text(made.error());
    solver_.emplace(std::move(*made));
  }

  Body body_ = std::move(bodies().front());
  Eigen::VectorXd right_ = random_vector(static_cast<Eigen::Index>(body_.mesh.node_count), 5);
  Eigen::VectorXd zero_ = Eigen::VectorXd::Zero(right_.size());
  std::optional<BrickSolver> solver_;
};

TEST_F(Solved, NeedsNoIterationFromSolution) {
  const auto first = solver_->solve(right_, zero_);
  ASSERT_TRUE(first);
  const auto second = solver_->solve(right_, first->x);
  ASSERT_TRUE(second);
  EXPECT_LE(second->iterations, 1);
  const auto nothing = solver_->solve(zero_, zero_);
  ASSERT_TRUE(nothing);
  EXPECT_EQ(nothing->iterations, 0);
  EXPECT_EQ(nothing->x.norm(), 0);
}

TEST_F(Solved, IsReproducible) {
  const auto first = solver_->solve(right_, zero_);
  const auto second = solver_->solve(right_, zero_);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->x, second->x);
}

TEST_F(Solved, AcceptsOtherCoefficients) {
  const ThermalCoefficients warmer{0.06, 0.03, 0.04, 15};
  solver_->replace(body_.model, body_.mesh, warmer);
  const auto solution = solver_->solve(right_, zero_);
  ASSERT_TRUE(solution) << text(solution.error());
  const auto matrix = conduction_matrix(body_.model, body_.mesh, warmer);
  EXPECT_LT((matrix * solution->x - right_).norm(), 1.1e-9 * right_.norm());
}

TEST_F(Solved, FailsWhenToleranceIsNotReached) {
  auto hasty = BrickSolver::create(body_.model, body_.mesh, kCoefficients, {.most_iterations = 2});
  ASSERT_TRUE(hasty);
  const auto solution = hasty->solve(right_, zero_);
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error().kind, FaultKind::numeric);
  EXPECT_NE(solution.error().what.find("after 2 iterations"), std::string::npos) << solution.error().what;
}

}  // namespace
}  // namespace gyrotherm::thermal
