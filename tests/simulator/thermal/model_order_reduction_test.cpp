// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/model_order_reduction.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "simulator/thermal/hex20.hpp"
#include "simulator/thermal/model_order_reduction_error.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr unsigned kReductionSeed = 4711;

ThermalPoint some_point(std::mt19937_64& random) {
  std::uniform_real_distribution<double> conductivity(0.02, 0.06);
  std::uniform_real_distribution<double> film(8, 25);
  std::uniform_real_distribution<double> exponent(-4, -1.5);
  return {{conductivity(random), conductivity(random), conductivity(random), film(random)},
          random() % 4 == 0 ? 0 : std::pow(10, exponent(random))};
}

SparseMatrix balance_of(const ThermalSystem& system, const ThermalPoint& p) {
  SparseMatrix sum = system.conduction + p.rate_per_s * system.capacity;
  for (std::size_t m = 0; m < kThermalCoefficients; ++m)
    sum = (sum + p.coefficients[m] * system.conduction_per[m]).eval();
  return sum;
}

Eigen::MatrixXd loads_of(const ThermalSystem& system, const ThermalPoint& p) {
  Eigen::MatrixXd loads = system.inputs;
  loads.col(0) += p.coefficients[3] * system.film_ambient;
  return loads;
}

TEST(BoxGyro, ConductsOnlyThroughFilmAtUniformTemperature) {
  const auto system = box_gyro();
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(system.capacity.rows());
  EXPECT_LE((system.conduction * one).cwiseAbs().maxCoeff(), 1e-14);
  for (std::size_t m = 0; m < 3; ++m) EXPECT_LE((system.conduction_per[m] * one).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE((system.conduction_per[3] * one - system.film_ambient).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE((system.outputs * one).array().abs().maxCoeff() - 1, 1e-14);
}

TEST(AffineMatrix, EqualsSum) {
  const auto system = box_gyro();
  AffineMatrix matrices(system);
  std::mt19937_64 random(kReductionSeed);
  for (int i = 0; i < 5; ++i) {
    SCOPED_TRACE(fmt::format("seed {}, {}", kReductionSeed, i));
    const auto p = some_point(random);
    const Eigen::MatrixXd difference = matrices.sum(p.rate_per_s, 1, p.coefficients) - balance_of(system, p);
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-15);
    const Eigen::MatrixXd half = matrices.sum(0, 0.5, p.coefficients);
    EXPECT_LE((2 * half - Eigen::MatrixXd(balance_of(system, {p.coefficients, 0}))).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(ReducedBasis, IsOrthonormalAndDropsDependentFields) {
  const auto system = box_gyro();
  const auto n = system.capacity.rows();
  std::srand(kReductionSeed);
  ReducedBasis basis(system, box_gyro_description(), Eigen::VectorXd::Ones(n), 20);
  const Eigen::MatrixXd fields = Eigen::MatrixXd::Random(n, 7);
  EXPECT_EQ(basis.grow(fields), 7);
  EXPECT_EQ(basis.grow(fields.leftCols(2) * 3), 0);
  EXPECT_EQ(basis.grow(Eigen::MatrixXd::Constant(n, 1, 5)), 0);
  // The basis is limited to 20 fields, so only 12 more fit.
  EXPECT_EQ(basis.grow(Eigen::MatrixXd::Random(n, 30)), 12);
  const Eigen::MatrixXd gram = basis.basis().transpose() * system.capacity * basis.basis();
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(20, 20)).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::MatrixXd direct = basis.basis().transpose() * system.conduction_per[1] * basis.basis();
  EXPECT_LE((basis.model().conduction_per[1] - direct).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(basis.model().conduction, basis.model().conduction.transpose());
}

TEST(ReducedBasis, EstimatesItsResidual) {
  const auto system = box_gyro();
  const auto n = system.capacity.rows();
  std::srand(kReductionSeed);
  Eigen::VectorXd weights = Eigen::VectorXd::Random(n).array().square() + 0.1;
  ReducedBasis basis(system, box_gyro_description(), weights, 20);
  basis.grow(Eigen::MatrixXd::Random(n, 11));
  std::mt19937_64 random(kReductionSeed);
  for (int i = 0; i < 20; ++i) {
    SCOPED_TRACE(fmt::format("seed {}, {}", kReductionSeed, i));
    const auto p = some_point(random);
    const Eigen::MatrixXd states = states_at(basis.model(), p.coefficients, p.rate_per_s);
    const Eigen::MatrixXd residual = loads_of(system, p) - balance_of(system, p) * (basis.basis() * states);
    const Eigen::VectorXd truth = (weights.cwiseSqrt().asDiagonal() * residual).colwise().norm();
    const Eigen::VectorXd estimate = basis.residuals(p, Eigen::MatrixXd::Identity(kThermalInputs, kThermalInputs));
    for (Eigen::Index j = 0; j < truth.size(); ++j) {
      if (p.rate_per_s == 0 && j == 0)
        // The response to the ambient is the constant field, which the basis contains.
        EXPECT_LE(estimate[j], 1e-12);
      else
        EXPECT_NEAR(estimate[j] / truth[j], 1, 0.25);
    }
  }
}

TEST(ModelOrderReduction, MatchesFullModelAtUnusedPoints) {
  const auto system = box_gyro();
  const auto& model = reduced_box_gyro();
  EXPECT_LE(model.conduction.rows(), 60);
  EXPECT_LE(model.error.transfer_k, 1e-4);
  const auto usual = reference_loads(model);
  std::mt19937_64 random(kReductionSeed);
  for (int i = 0; i < 12; ++i) {
    auto p = some_point(random);
    // The air coefficients come first, then the gaps, which are equal.
    if (i < 6) {
      p.coefficients = coefficients_at(model, -60.0 + 25 * i, i % 2 == 0 ? GyroFilm::still : GyroFilm::chamber);
    } else {
      p.coefficients[1] = p.coefficients[2] = p.coefficients[0];
    }
    SCOPED_TRACE(fmt::format("seed {}, {}: s = {}", kReductionSeed, i, p.rate_per_s));
    const auto full = direct_solver()(balance_of(system, p), loads_of(system, p));
    ASSERT_TRUE(full);
    const Eigen::MatrixXd miss =
        system.outputs * *full - model.outputs * states_at(model, p.coefficients, p.rate_per_s);
    EXPECT_LE((miss * usual).cwiseAbs().maxCoeff(), 3e-4);
  }
}

TEST(ModelOrderReduction, StaysSymmetricAndStable) {
  const auto& model = reduced_box_gyro();
  EXPECT_EQ(model.conduction, model.conduction.transpose());
  for (const auto& matrix : model.conduction_per) {
    EXPECT_EQ(matrix, matrix.transpose());
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues()[0], -1e-9 * matrix.norm());
  }
}

TEST(ModelOrderReduction, KeepsSymmetryOfGyro) {
  const auto& model = reduced_box_gyro();
  const auto c = coefficients_at(model, 20, GyroFilm::chamber);
  const Eigen::MatrixXd answers = model.outputs * states_at(model, c, 1e-3);
  constexpr auto kLeft = static_cast<Eigen::Index>(ThermalInput::gain_left);
  constexpr auto kRight = static_cast<Eigen::Index>(ThermalInput::gain_right);
  EXPECT_NEAR(answers(1, kLeft), answers(2, kRight), 1e-3);
  EXPECT_NEAR(answers(5, kLeft), answers(7, kRight), 1e-3);
}

TEST(ModelOrderReduction, FailsWithErrorAndPointWhenStatesAreTooFew) {
  const auto model =
      reduce(box_gyro(), box_gyro_description(), {.states = 8, .most_fields = 20, .goal_k = 1e-4}, direct_solver());
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, FaultKind::numeric);
  EXPECT_NE(model.error().what.find("8 states have an error of"), std::string::npos) << model.error().what;
  EXPECT_NE(model.error().what.find("expected at most 1.0e-04 K"), std::string::npos) << model.error().what;
}

TEST(ModelOrderReduction, StopsWhenInterrupted) {
  int calls = 0;
  const auto model = reduce(box_gyro(), box_gyro_description(), {}, direct_solver(),
                            [&](std::string_view, double fraction) { return fraction >= 0 && ++calls < 4; });
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, FaultKind::interrupted);
  EXPECT_EQ(calls, 4);
}

TEST(ModelOrderReduction, ReturnsFaultOfSolver) {
  const SolveColumns broken = [](const SparseMatrix&, const Eigen::MatrixXd&) -> Result<Eigen::MatrixXd> {
    return failure(FaultKind::numeric, "solver", "out of order");
  };
  const auto model = reduce(box_gyro(), box_gyro_description(), {}, broken);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().what, "out of order");
}

TEST(ReductionError, IsSmallOverTimeOfPrograms) {
  const auto system = box_gyro();
  for (const double air_c : {-40.0, 60.0}) {
    const auto error = measure(system, reduced_box_system(), {.air_c = air_c, .shortest_s = 10}, direct_solver());
    ASSERT_TRUE(error) << text(error.error());
    EXPECT_GT(error->ramp_k, 0);
    EXPECT_LE(error->ramp_k, 1e-3);
    EXPECT_LE(error->switch_on_k, 1e-2);
  }
}

}  // namespace
}  // namespace gyrotherm::thermal
