// SPDX-License-Identifier: Apache-2.0
/// Compares the finite elements with known solutions.
#include "simulator/thermal/assembly.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <numbers>

#include "simulator/thermal/hex20.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr MaterialProperties kStuff{2000, 500, 1.5};

Eigen::VectorXd solved(const SparseMatrix& matrix, const Eigen::VectorXd& right) {
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor{Eigen::SparseMatrix<double>(matrix)};
  EXPECT_EQ(factor.info(), Eigen::Success);
  return factor.solve(right);
}

/// The solution T − T_amb = P/(2 h A) + q/(2k) (L²/4 − (x − L/2)²) with q = P/(A L) is quadratic, so the elements
/// represent it exactly.
TEST(Slab, IsExactWithSourceAndFilm) {
  const double length = 0.02;
  const double film = 7;
  const auto mesh =
      box_of(GyroPart::gain_left, {0, 0.003, 0.011, length}, even_lines(0.01, 2), even_lines(0.03, 2), {0, 1});
  const auto model = uniform_model(kStuff);
  const auto matrix = conduction_matrix(model, mesh, {0, 0, 0, film});
  const double watts = 0.4;
  const Eigen::VectorXd rise = solved(matrix, watts * assemble_inputs(mesh).col(1));
  const ThermalField field(model, mesh, rise);
  const double face = 0.01 * 0.03;
  for (const double x : {0.0, 0.001, 0.0125, length}) {
    const double middle = x - length / 2;
    const double expected = watts / (2 * film * face) + watts / (face * length) / (2 * kStuff.conductivity_w_per_m_k) *
                                                            (length * length / 4 - middle * middle);
    EXPECT_NEAR(field.temperature_at(x, 0.004, 0.011), expected, 1e-9 * expected) << x;
  }
  EXPECT_TRUE(std::isnan(field.temperature_at(-0.001, 0.004, 0.011)));
}

/// A body that conducts much better than its film cools uniformly: T = e^(−h A t / (ρ c V)). The trapezoidal rule is
/// used with the steps dt and dt/2.
TEST(Lump, CoolsWithTimeConstant) {
  const MaterialProperties copper{8900, 385, 4e5};
  const auto mesh =
      box_of(GyroPart::block, even_lines(0.02, 2), even_lines(0.02, 2), even_lines(0.02, 2), {0, 1, 2, 3, 4, 5});
  const auto model = uniform_model(copper);
  const double film = 20;
  const double tau = copper.density_kg_per_m3 * copper.specific_heat_j_per_kg_k * 0.02 / (6 * film);
  const auto capacity = assemble_capacity(model, mesh);
  const auto conduction = conduction_matrix(model, mesh, {0, 0, 0, film});
  std::array<double, 2> error{};
  for (const int half : {0, 1}) {
    const int steps = half == 0 ? 10 : 20;
    const double dt = tau / steps;
    const SparseMatrix left = capacity / dt + conduction / 2;
    const SparseMatrix right = capacity / dt - conduction / 2;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor{Eigen::SparseMatrix<double>(left)};
    Eigen::VectorXd t = Eigen::VectorXd::Ones(left.rows());
    for (int step = 0; step < steps; ++step) t = factor.solve(right * t);
    error[half] = t.mean() - std::exp(-1);
  }
  EXPECT_NEAR(error[1], 0, 1e-4);
  EXPECT_NEAR(error[0] / error[1], 4, 0.1) << "second order in time";
}

/// Returns the L2 error of the solution of (K + s C) T = f for T = cos πx cos πy cos πz on the unit cube. No heat flows
/// through its faces.
double manufactured_error(int pieces) {
  const auto lines = even_lines(1, pieces);
  const auto mesh = box_of(GyroPart::block, lines, lines, lines, {});
  const auto model = uniform_model({1, 1, 1});
  constexpr double kPi = std::numbers::pi;
  const auto exact = [](double x, double y, double z) {
    return std::cos(kPi * x) * std::cos(kPi * y) * std::cos(kPi * z);
  };
  const double source = 3 * kPi * kPi + 1;
  constexpr std::array<double, 4> kAt{-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
  constexpr std::array<double, 4> kWeight{0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                          0.3478548451374538};
  const double h = 1.0 / pieces;
  const auto each_point = [&](auto visit) {
    for (int k = 0; k < pieces; ++k)
      for (int j = 0; j < pieces; ++j)
        for (int i = 0; i < pieces; ++i) {
          const auto nodes = brick_nodes(mesh, i, j, k);
          for (int p = 0; p < 4; ++p)
            for (int q = 0; q < 4; ++q)
              for (int r = 0; r < 4; ++r)
                visit(nodes, hex20_shape(kAt[p], kAt[q], kAt[r]),
                      exact(h * (i + (kAt[p] + 1) / 2), h * (j + (kAt[q] + 1) / 2), h * (k + (kAt[r] + 1) / 2)),
                      kWeight[p] * kWeight[q] * kWeight[r] * h * h * h / 8);
        }
  };
  Eigen::VectorXd load = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mesh.node_count));
  each_point([&](const auto& nodes, const Hex20Vector& shape, double value, double weight) {
    for (int n = 0; n < kHex20; ++n) load[nodes[n]] += weight * source * value * shape[n];
  });
  const SparseMatrix matrix = conduction_matrix(model, mesh, {}) + assemble_capacity(model, mesh);
  const auto field = solved(matrix, load);
  double square = 0;
  each_point([&](const auto& nodes, const Hex20Vector& shape, double value, double weight) {
    double found = 0;
    for (int n = 0; n < kHex20; ++n) found += shape[n] * field[nodes[n]];
    square += weight * (found - value) * (found - value);
  });
  return std::sqrt(square);
}

TEST(ManufacturedSolution, ConvergesWithThirdPowerOfEdge) {
  const double coarse = manufactured_error(3);
  const double fine = manufactured_error(6);
  const double order = std::log2(coarse / fine);
  EXPECT_GT(order, 2.7) << coarse << ' ' << fine;
  EXPECT_LT(fine, 1e-3);
}

class Assembly : public testing::Test {
 protected:
  GyroModel model_ = shipped_gyro("fast-film");
  GyroMesh mesh_ = make_mesh(model_, 9.0);
  ThermalSystem system_ = assemble(model_, mesh_);
};

double largest(const SparseMatrix& matrix) {
  double most = 0;
  for (Eigen::Index n = 0; n < matrix.nonZeros(); ++n) most = std::max(most, std::abs(matrix.valuePtr()[n]));
  return most;
}

TEST_F(Assembly, ConductsOnlyThroughFilmAtConstantTemperature) {
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(system_.film_ambient.size());
  EXPECT_LT((system_.conduction * one).lpNorm<Eigen::Infinity>(), 1e-12 * largest(system_.conduction));
  for (const auto c : {ThermalCoefficient::air_lid, ThermalCoefficient::air_side, ThermalCoefficient::air_base})
    EXPECT_LT((system_.conduction_per[static_cast<std::size_t>(c)] * one).lpNorm<Eigen::Infinity>(), 1e-12);
  const auto& film = system_.conduction_per[static_cast<std::size_t>(ThermalCoefficient::film)];
  EXPECT_LT((film * one - system_.film_ambient).lpNorm<Eigen::Infinity>(), 1e-15);
}

TEST_F(Assembly, HasSymmetricMatrices) {
  const auto expect_symmetric = [](const SparseMatrix& m) {
    EXPECT_LE(largest(SparseMatrix(m - SparseMatrix(m.transpose()))), 1e-15 * largest(m));
  };
  expect_symmetric(system_.capacity);
  expect_symmetric(system_.conduction);
  for (const auto& m : system_.conduction_per) expect_symmetric(m);
}

TEST_F(Assembly, HasHeatCapacityOfParts) {
  double expected = 0;
  for (std::size_t part = 0; part < kGyroParts; ++part) {
    const auto& material = model_.materials[static_cast<std::size_t>(part_material(static_cast<GyroPart>(part)))];
    expected += part_volume(mesh_, static_cast<GyroPart>(part)) * material.density_kg_per_m3 *
                material.specific_heat_j_per_kg_k;
  }
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(system_.film_ambient.size());
  EXPECT_NEAR(one.dot(system_.capacity * one) / expected, 1, 1e-12);
}

TEST_F(Assembly, HasInputsOfOneWattAndOutputsThatAreMeans) {
  EXPECT_EQ(system_.inputs.col(0).norm(), 0);
  for (Eigen::Index input = 1; input < system_.inputs.cols(); ++input)
    EXPECT_NEAR(system_.inputs.col(input).sum(), 1, 1e-12) << input;
  const Eigen::VectorXd sums = system_.outputs * Eigen::VectorXd::Ones(system_.outputs.cols());
  for (Eigen::Index output = 0; output < sums.size(); ++output) EXPECT_NEAR(sums[output], 1, 1e-12) << output;
}

TEST_F(Assembly, EvaluatesLinearFieldExactly) {
  Eigen::VectorXd field(static_cast<Eigen::Index>(mesh_.node_count));
  std::size_t point = 0;
  for (int k = 0; k <= 2 * mesh_.nz(); ++k)
    for (int j = 0; j <= 2 * mesh_.ny(); ++j)
      for (int i = 0; i <= 2 * mesh_.nx(); ++i, ++point)
        if (mesh_.nodes[point] >= 0)
          field[mesh_.nodes[point]] = doubled_coordinate(mesh_.x, i) + 10 * doubled_coordinate(mesh_.y, j) +
                                      100 * doubled_coordinate(mesh_.z, k);
  const Eigen::VectorXd y = system_.outputs * field;
  for (int t = 0; t < 8; ++t) {
    const auto& [u, v] = model_.thermometers[t];
    EXPECT_NEAR(y[t], 0.075 + 1e-3 * u + 10 * (0.075 + 1e-3 * v) + 100 * 0.0525, 1e-12) << t;
  }
  EXPECT_NEAR(y[static_cast<Eigen::Index>(ThermalOutput::shell)], 0.075 + 0.75 + 4, 1e-9);
  EXPECT_NEAR(y[static_cast<Eigen::Index>(ThermalOutput::preamplifier)], 0.075 + 0.08 + 4, 1e-9);
}

}  // namespace
}  // namespace gyrotherm::thermal
