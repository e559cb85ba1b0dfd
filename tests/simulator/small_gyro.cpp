// SPDX-License-Identifier: Apache-2.0
#include "tests/simulator/small_gyro.hpp"

#include <array>

namespace gyrotherm::simulator {
namespace {

constexpr Eigen::Index kShell = 8;
constexpr Eigen::Index kNodes = 9;
// B A C E H G F D B.
constexpr std::array<Eigen::Index, 9> kRing{1, 0, 2, 4, 7, 6, 5, 3, 1};

void conduct(Eigen::MatrixXd& matrix, Eigen::Index a, Eigen::Index b, double w_per_k) {
  matrix(a, a) += w_per_k;
  matrix(b, b) += w_per_k;
  matrix(a, b) -= w_per_k;
  matrix(b, a) -= w_per_k;
}

/// Nodes of each output, in the order of ThermalOutput. The output is their mean.
Eigen::MatrixXd means() {
  const std::vector<std::vector<Eigen::Index>> nodes{{0}, {1}, {2}, {3},    {4},    {5},
                                                     {6}, {7}, {8}, {1, 3}, {2, 4}, {5, 6, 7},
                                                     {8}, {1}, {2}, {5},    {7},    {0, 1, 2, 3, 4, 5, 6, 7}};
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(thermal::kThermalOutputs), kNodes);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto& of = nodes[static_cast<std::size_t>(i)];
    for (const auto node : of) rows(i, node) = 1.0 / static_cast<double>(of.size());
  }
  return rows;
}

}  // namespace

thermal::ReducedModel small_gyro() {
  constexpr double kFilmArea = 0.09;  // m²
  // Area over width of each of the three gaps, m.
  constexpr double kGapPerNode = 0.24;
  Eigen::VectorXd root_capacity = Eigen::VectorXd::Constant(kNodes, std::sqrt(50.0));
  root_capacity[kShell] = std::sqrt(670.0);
  const Eigen::VectorXd scale = root_capacity.cwiseInverse();

  thermal::ReducedModel model;
  model.gyro = "small";
  model.source_sha256 = std::string(64, '0');
  model.mesh = "nine nodes";
  model.air = {.lid = {1, 0.05, 0.0245}, .side = {1, 0.05, 0.017}, .base = {1, 0.05, 0.0245}};
  model.powers_w = {0.294, 0.294, 0.784, 0.072, 0.072};
  model.still_film_w_per_m2_k = 8;
  model.chamber_film_w_per_m2_k = 25;

  model.conduction = Eigen::MatrixXd::Zero(kNodes, kNodes);
  for (std::size_t i = 1; i < kRing.size(); ++i) conduct(model.conduction, kRing[i - 1], kRing[i], 0.06);
  for (auto& matrix : model.conduction_per) matrix = Eigen::MatrixXd::Zero(kNodes, kNodes);
  for (std::size_t gap = 0; gap < 3; ++gap)
    for (Eigen::Index node = 0; node < kShell; ++node) conduct(model.conduction_per[gap], node, kShell, kGapPerNode);
  model.conduction_per[3](kShell, kShell) = kFilmArea;

  model.inputs = Eigen::MatrixXd::Zero(kNodes, static_cast<Eigen::Index>(thermal::kThermalInputs));
  model.inputs.col(1) << 0.25, 0.5, 0, 0.25, 0, 0, 0, 0, 0;
  model.inputs.col(2) << 0.25, 0, 0.5, 0, 0.25, 0, 0, 0, 0;
  model.inputs(kShell, 3) = 1;
  model.inputs(3, 4) = 1;
  model.inputs(4, 5) = 1;
  model.film_ambient = Eigen::VectorXd::Zero(kNodes);
  model.film_ambient[kShell] = kFilmArea;

  model.conduction = (scale.asDiagonal() * model.conduction * scale.asDiagonal()).eval();
  for (auto& matrix : model.conduction_per) matrix = (scale.asDiagonal() * matrix * scale.asDiagonal()).eval();
  model.inputs = (scale.asDiagonal() * model.inputs).eval();
  model.film_ambient = scale.cwiseProduct(model.film_ambient).eval();
  model.outputs = means() * scale.asDiagonal();
  return model;
}

}  // namespace gyrotherm::simulator
