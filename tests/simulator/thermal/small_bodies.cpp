// SPDX-License-Identifier: Apache-2.0
#include "tests/simulator/thermal/small_bodies.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>
#include <vector>

#include "core/file.hpp"
#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/hex20.hpp"

namespace gyrotherm::thermal {

std::string gyro_text(const std::string& name) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/" + name + ".toml");
  EXPECT_TRUE(text) << name;
  return text.value_or("");
}

GyroModel shipped_gyro(const std::string& name) {
  const auto model = parse_gyro(gyro_text(name), name);
  EXPECT_TRUE(model) << text(model.error());
  return model.value_or(GyroModel{});
}

std::vector<double> even_lines(double length, int pieces) {
  std::vector<double> lines;
  for (int i = 0; i <= pieces; ++i) lines.push_back(length * i / pieces);
  return lines;
}

GyroMesh box_of(GyroPart part, std::vector<double> x, std::vector<double> y, std::vector<double> z,
                const std::vector<int>& film_faces) {
  GyroMesh mesh;
  mesh.x = std::move(x);
  mesh.y = std::move(y);
  mesh.z = std::move(z);
  mesh.classes = {{}, {{{part, 1.0}}, {}}};
  mesh.bricks.assign(static_cast<std::size_t>(mesh.nx()) * mesh.ny() * mesh.nz(), 1);
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i) {
        const bool outer[] = {i == 0, i == mesh.nx() - 1, j == 0, j == mesh.ny() - 1, k == 0, k == mesh.nz() - 1};
        for (const int face : film_faces)
          if (outer[face]) mesh.film.push_back({mesh.brick(i, j, k), face, 1});
      }
  number_nodes(mesh);
  return mesh;
}

GyroModel uniform_model(const MaterialProperties& properties) {
  GyroModel model;
  model.materials.fill(properties);
  return model;
}

SparseMatrix conduction_matrix(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients) {
  const auto system = assemble(model, mesh);
  return AffineMatrix(system).sum(0, 1, coefficients);
}

Eigen::VectorXd random_vector(Eigen::Index size, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(engine); });
}

namespace {

constexpr int kX = 8;
constexpr int kY = 8;
constexpr int kZ = 6;
constexpr double kCell_m = 0.018;

enum class Matter { shell, air, block };

struct Cell {
  int x, y, z;
  [[nodiscard]] bool inside() const { return x >= 0 && x < kX && y >= 0 && y < kY && z >= 0 && z < kZ; }
  [[nodiscard]] int index() const { return x + kX * (y + kY * z); }
  [[nodiscard]] Matter matter() const {
    if (x == 0 || x == kX - 1 || y == 0 || y == kY - 1 || z == 0 || z == kZ - 1) return Matter::shell;
    return x >= 2 && x <= 5 && y >= 2 && y <= 5 && (z == 2 || z == 3) ? Matter::block : Matter::air;
  }
  [[nodiscard]] std::size_t gap() const { return z >= 4 ? 0 : z <= 1 ? 2 : 1; }
  [[nodiscard]] double conductivity() const { return matter() == Matter::shell ? 20 : 1.46; }
  [[nodiscard]] double capacity_j_per_k() const {
    const double per_m3 = matter() == Matter::shell ? 2.4e6 : matter() == Matter::block ? 2.0e6 : 1.2e3;
    return per_m3 * kCell_m * kCell_m * kCell_m;
  }
};

std::vector<Cell> cells() {
  std::vector<Cell> all;
  for (int z = 0; z < kZ; ++z)
    for (int y = 0; y < kY; ++y)
      for (int x = 0; x < kX; ++x) all.push_back({x, y, z});
  return all;
}

using Triplets = std::vector<Eigen::Triplet<double>>;

void conduct(Triplets& to, int i, int j, double w_per_k) {
  to.emplace_back(i, i, w_per_k);
  to.emplace_back(j, j, w_per_k);
  to.emplace_back(i, j, -w_per_k);
  to.emplace_back(j, i, -w_per_k);
}

/// Adds the conduction between two neighbours. The resistance of a solid next to air is neglected, so the system is
/// affine in the coefficients.
void connect(const Cell& a, const Cell& b, Triplets& fixed, std::array<Triplets, kThermalCoefficients>& per) {
  const bool air_a = a.matter() == Matter::air;
  const bool air_b = b.matter() == Matter::air;
  if (!air_a && !air_b) {
    const double k = 2 / (1 / a.conductivity() + 1 / b.conductivity());
    return conduct(fixed, a.index(), b.index(), k * kCell_m);
  }
  const double length = air_a && air_b ? 1 : 0.5;
  if (air_a) conduct(per[a.gap()], a.index(), b.index(), kCell_m / (2 * length) * (air_b ? 1 : 2));
  if (air_b) conduct(per[b.gap()], a.index(), b.index(), kCell_m / (2 * length) * (air_a ? 1 : 2));
}

SparseMatrix matrix_of(const Triplets& triplets) {
  SparseMatrix matrix(kX * kY * kZ, kX * kY * kZ);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

int outer_faces(const Cell& c) {
  return (c.x == 0) + (c.x == kX - 1) + (c.y == 0) + (c.y == kY - 1) + (c.z == 0) + (c.z == kZ - 1);
}

/// Adds an output: the mean over the cells for which `belongs` is true.
template <class Belongs>
void mean(Triplets& outputs, ThermalOutput row, Belongs belongs) {
  const auto all = cells();
  const auto count = std::ranges::count_if(all, belongs);
  for (const auto& cell : all)
    if (belongs(cell)) outputs.emplace_back(static_cast<int>(row), cell.index(), 1.0 / static_cast<double>(count));
}

template <class Belongs>
void heat(Eigen::MatrixXd& inputs, ThermalInput column, Belongs belongs) {
  const auto all = cells();
  const auto count = std::ranges::count_if(all, belongs);
  for (const auto& cell : all)
    if (belongs(cell)) inputs(cell.index(), static_cast<Eigen::Index>(column)) = 1.0 / static_cast<double>(count);
}

bool is_block(const Cell& c) { return c.matter() == Matter::block; }
bool is_shell(const Cell& c) { return c.matter() == Matter::shell; }
bool is_gain_left(const Cell& c) { return is_block(c) && c.x <= 3 && c.y == 5 && c.z == 3; }
bool is_gain_right(const Cell& c) { return is_block(c) && c.x >= 4 && c.y == 5 && c.z == 3; }
bool is_passive(const Cell& c) { return is_block(c) && c.y == 2 && c.z == 3; }
bool is_preamplifier(const Cell& c) { return c.y == 0 && c.x >= 2 && c.x <= 5 && (c.z == 2 || c.z == 3); }

SparseMatrix outputs() {
  Triplets rows;
  constexpr std::array<std::array<int, 4>, 8> kPlaces{
      {{3, 4, 5, 5}, {2, 2, 5, 5}, {5, 5, 5, 5}, {2, 2, 3, 4}, {5, 5, 3, 4}, {2, 2, 2, 2}, {3, 4, 2, 2}, {5, 5, 2, 2}}};
  for (std::size_t i = 0; i < kPlaces.size(); ++i) {
    const auto& p = kPlaces[i];
    mean(rows, static_cast<ThermalOutput>(i),
         [&](const Cell& c) { return c.z == 3 && c.x >= p[0] && c.x <= p[1] && c.y >= p[2] && c.y <= p[3]; });
  }
  mean(rows, ThermalOutput::shell, is_shell);
  mean(rows, ThermalOutput::gain_left, is_gain_left);
  mean(rows, ThermalOutput::gain_right, is_gain_right);
  mean(rows, ThermalOutput::passive_bore, is_passive);
  mean(rows, ThermalOutput::preamplifier, is_preamplifier);
  mean(rows, ThermalOutput::mirror_b, [](const Cell& c) { return is_block(c) && c.x == 2 && c.y == 5; });
  mean(rows, ThermalOutput::mirror_c, [](const Cell& c) { return is_block(c) && c.x == 5 && c.y == 5; });
  mean(rows, ThermalOutput::mirror_f, [](const Cell& c) { return is_block(c) && c.x == 2 && c.y == 2; });
  mean(rows, ThermalOutput::mirror_h, [](const Cell& c) { return is_block(c) && c.x == 5 && c.y == 2; });
  mean(rows, ThermalOutput::block, is_block);
  SparseMatrix matrix(kThermalOutputs, kX * kY * kZ);
  matrix.setFromTriplets(rows.begin(), rows.end());
  return matrix;
}

}  // namespace

ThermalSystem box_gyro() {
  ThermalSystem system;
  Triplets capacity, fixed;
  std::array<Triplets, kThermalCoefficients> per;
  system.inputs = Eigen::MatrixXd::Zero(kX * kY * kZ, kThermalInputs);
  system.film_ambient = Eigen::VectorXd::Zero(kX * kY * kZ);
  for (const auto& cell : cells()) {
    const int i = cell.index();
    capacity.emplace_back(i, i, cell.capacity_j_per_k());
    for (const auto& next :
         {Cell{cell.x + 1, cell.y, cell.z}, Cell{cell.x, cell.y + 1, cell.z}, Cell{cell.x, cell.y, cell.z + 1}}) {
      if (!next.inside()) continue;
      connect(cell, next, fixed, per);
      const double shared = 0.05 * std::min(cell.capacity_j_per_k(), next.capacity_j_per_k());
      capacity.emplace_back(i, next.index(), shared);
      capacity.emplace_back(next.index(), i, shared);
    }
    const double area_m2 = outer_faces(cell) * kCell_m * kCell_m;
    if (area_m2 > 0) per[3].emplace_back(i, i, area_m2);
    system.film_ambient[i] = area_m2;
  }
  system.capacity = matrix_of(capacity);
  system.conduction = matrix_of(fixed);
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) system.conduction_per[m] = matrix_of(per[m]);
  heat(system.inputs, ThermalInput::gain_left, is_gain_left);
  heat(system.inputs, ThermalInput::gain_right, is_gain_right);
  heat(system.inputs, ThermalInput::preamplifier, is_preamplifier);
  heat(system.inputs, ThermalInput::ballast_left, [](const Cell& c) { return c.x == 2 && c.y == 3 && c.z == 2; });
  heat(system.inputs, ThermalInput::ballast_right, [](const Cell& c) { return c.x == 5 && c.y == 3 && c.z == 2; });
  system.outputs = outputs();
  return system;
}

ReducedModel box_gyro_description() {
  ReducedModel about;
  about.gyro = "small.toml";
  about.source_sha256 = std::string(64, '0');
  about.mesh = "384 cells";
  about.air = {.lid = {.nusselt = 1.4, .emissivity = 0.05, .width_m = 0.018},
               .side = {.nusselt = 1.0, .emissivity = 0.05, .width_m = 0.018},
               .base = {.nusselt = 1.0, .emissivity = 0.04, .width_m = 0.018}};
  about.powers_w = {0.294, 0.294, 0.784, 0.072, 0.072};
  about.still_film_w_per_m2_k = 8;
  about.chamber_film_w_per_m2_k = 25;
  return about;
}

SolveColumns direct_solver() {
  return [](const SparseMatrix& matrix, const Eigen::MatrixXd& right) -> Result<Eigen::MatrixXd> {
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor((Eigen::SparseMatrix<double>(matrix)));
    if (factor.info() != Eigen::Success) return failure(FaultKind::numeric, "factorisation", "not positive definite");
    return Eigen::MatrixXd(factor.solve(right));
  };
}

const ReducedSystem& reduced_box_system() {
  static const ReducedSystem reduced = [] {
    auto made =
        reduce(box_gyro(), box_gyro_description(), {.states = 60, .most_fields = 90, .goal_k = 1e-4}, direct_solver());
    if (!made) std::abort();
    return *made;
  }();
  return reduced;
}

const ReducedModel& reduced_box_gyro() { return reduced_box_system().model; }

}  // namespace gyrotherm::thermal
