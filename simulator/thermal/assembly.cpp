// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/assembly.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cassert>
#include <limits>
#include <utility>
#include <vector>

#include "simulator/thermal/hex20.hpp"

namespace gyrotherm::thermal {
namespace {

/// Material values of a brick class in a matrix: conductivities, or the heat capacity by volume, J/(m³·K).
struct BrickWeight {
  Conductivity k;
  double capacity{};
};

// Number of points of the doubled grid that are at most two steps from a point along each axis.
constexpr int kNeighbourPoints = 125;
using NeighbourSet = std::bitset<kNeighbourPoints>;

/// Position of each node of a brick relative to each other node: its index among the 125 points around it. The indices
/// are in the order of node numbers.
struct NodeNeighbours {
  std::array<std::array<int, kHex20>, kHex20> of{};
  std::array<NeighbourSet, kHex20> reached{};
  /// Node of the brick at a position; −1: none.
  std::array<int, 27> node_at{};
};

NodeNeighbours make_neighbours() {
  NodeNeighbours neighbours;
  neighbours.node_at.fill(-1);
  for (int n = 0; n < kHex20; ++n) {
    const auto& from = kHex20Positions[n];
    neighbours.node_at[from[0] + 3 * from[1] + 9 * from[2]] = n;
    for (int m = 0; m < kHex20; ++m) {
      const auto& to = kHex20Positions[m];
      neighbours.of[n][m] = (to[0] - from[0] + 2) + 5 * (to[1] - from[1] + 2) + 25 * (to[2] - from[2] + 2);
      neighbours.reached[n].set(neighbours.of[n][m]);
    }
  }
  return neighbours;
}

/// First and last brick that contain a point of the doubled grid, along one axis.
struct Span {
  int from, to;
};
Span span(int position, int bricks) {
  const int last = position / 2;
  return {std::max(0, position % 2 == 0 ? last - 1 : last), std::min(bricks - 1, last)};
}

class Rows {
 public:
  Rows(const GyroMesh& mesh, std::vector<BrickWeight> weight_of_class)
      : mesh_(mesh),
        weights_(std::move(weight_of_class)),
        neighbours_(make_neighbours()),
        reference_(hex20_integrals()) {}

  SparseMatrix assemble() {
    const auto n = static_cast<Eigen::Index>(mesh_.node_count);
    SparseMatrix matrix(n, n);
    auto* outer = matrix.outerIndexPtr();
    outer[0] = 0;
    each_node(mesh_, [&](int node, int I, int J, int K) {
      NeighbourSet reached;
      each_brick_at(I, J, K,
                    [&](int, int, int, int local, const BrickWeight&) { reached |= neighbours_.reached[local]; });
      outer[node + 1] = static_cast<int>(reached.count());
    });
    std::int64_t total = 0;
    for (Eigen::Index row = 0; row < n; ++row) {
      total += outer[row + 1];
      assert(total < std::int64_t{1} << 31);
      outer[row + 1] = static_cast<int>(total);
    }
    matrix.resizeNonZeros(total);
    each_node(mesh_, [&](int node, int I, int J, int K) { fill(matrix, node, I, J, K); });
    return matrix;
  }

 private:
  /// Visits the non-empty bricks around a point, with the point's node number in each.
  template <class Visit>
  void each_brick_at(int I, int J, int K, Visit visit) const {
    const auto xs = span(I, mesh_.nx());
    const auto ys = span(J, mesh_.ny());
    const auto zs = span(K, mesh_.nz());
    for (int k = zs.from; k <= zs.to; ++k)
      for (int j = ys.from; j <= ys.to; ++j)
        for (int i = xs.from; i <= xs.to; ++i) {
          const auto& weight = weights_[mesh_.bricks[mesh_.brick(i, j, k)]];
          if (weight.k.zz == 0 && weight.k.xx == 0 && weight.capacity == 0) continue;
          visit(i, j, k, neighbours_.node_at[(I - 2 * i) + 3 * (J - 2 * j) + 9 * (K - 2 * k)], weight);
        }
  }

  void fill(SparseMatrix& matrix, int node, int I, int J, int K) {
    std::array<double, kNeighbourPoints> sum{};
    NeighbourSet reached;
    each_brick_at(I, J, K, [&](int i, int j, int k, int local, const BrickWeight& weight) {
      reached |= neighbours_.reached[local];
      const auto h = edges(mesh_, i, j, k);
      const double eighth = h.volume() / 8;
      const double x = 4 * eighth * weight.k.xx / (h.x * h.x);
      const double y = 4 * eighth * weight.k.yy / (h.y * h.y);
      const double z = 4 * eighth * weight.k.zz / (h.z * h.z);
      const double xy = 4 * eighth * weight.k.xy / (h.x * h.y);
      const double c = eighth * weight.capacity;
      const auto& r = reference_;
      Hex20Vector column = x * r.slopes[0].col(local) + y * r.slopes[1].col(local) + z * r.slopes[2].col(local);
      if (xy != 0) column += xy * r.cross.col(local);
      if (c != 0) column += c * r.mass.col(local);
      const auto& at = neighbours_.of[local];
      for (int m = 0; m < kHex20; ++m) sum[at[m]] += column[m];
    });
    auto entry = matrix.outerIndexPtr()[node];
    for (int o = 0; o < kNeighbourPoints; ++o) {
      if (!reached[o]) continue;
      const auto point = mesh_.point(I + o % 5 - 2, J + o / 5 % 5 - 2, K + o / 25 - 2);
      matrix.innerIndexPtr()[entry] = mesh_.nodes[point];
      matrix.valuePtr()[entry++] = sum[o];
    }
  }

  const GyroMesh& mesh_;
  std::vector<BrickWeight> weights_;
  NodeNeighbours neighbours_;
  const Hex20Integrals& reference_;
};

/// Visits each pair of nodes of each film face with its contribution per unit of film.
template <class Visit>
void each_film_entry(const GyroMesh& mesh, Visit visit) {
  const auto& reference = hex20_integrals();
  for (const auto& face : mesh.film) {
    const auto [i, j, k] = mesh.brick_position(face.brick);
    const auto nodes = brick_nodes(mesh, i, j, k);
    const double scale = face.factor * edges(mesh, i, j, k).face_area(face.face) / 4;
    for (int n = 0; n < kHex20; ++n)
      for (int m = 0; m < kHex20; ++m)
        if (const double value = reference.face_mass[face.face](n, m); value != 0)
          visit(nodes[n], nodes[m], scale * value);
  }
}

constexpr std::array<GyroPart, 3> kGaps{GyroPart::air_lid, GyroPart::air_side, GyroPart::air_base};

/// Parts of the outputs after the thermometers, in the order of the outputs. Each output is the mean of its part.
constexpr std::array<GyroPart, kThermalOutputs - 8> kOutputParts{
    GyroPart::shell,    GyroPart::gain_left, GyroPart::gain_right, GyroPart::passive_bore, GyroPart::preamplifier,
    GyroPart::mirror_b, GyroPart::mirror_c,  GyroPart::mirror_f,   GyroPart::mirror_h,     GyroPart::block};
/// Parts that are heated by the inputs after the ambient, in the order of the inputs.
constexpr std::array<GyroPart, kThermalInputs - 1> kInputParts{
    GyroPart::gain_left, GyroPart::gain_right, GyroPart::preamplifier, GyroPart::ballast_left, GyroPart::ballast_right};

const MaterialProperties& properties(const GyroModel& model, GyroPart part) {
  return model.materials[static_cast<std::size_t>(part_material(part))];
}

/// A value as the affine function c₀ + Σ c_m k_m of the conductivities of the gaps.
struct Affine {
  double fixed{};
  std::array<double, kGaps.size()> per_gap{};
};
struct AffineConductivity {
  Affine along;
  Affine across;
};

// Air conductivity at which the conductivity across a face is linearised, W/(m·K).
constexpr double kTypicalAir = 0.03;

AffineConductivity affine_conductivity(const GyroModel& model, const BrickClass& brick) {
  AffineConductivity sum;
  double resistance = 0;
  for (const auto& [part, share] : brick.shares) {
    const auto gap = std::ranges::find(kGaps, part);
    const bool air = gap != kGaps.end();
    const double k = air ? kTypicalAir : properties(model, part).conductivity_w_per_m_k;
    (air ? sum.along.per_gap[gap - kGaps.begin()] : sum.along.fixed) += air ? share : share * k;
    resistance += share / k;
    if (air) sum.across.per_gap[gap - kGaps.begin()] = share / (k * k);
  }
  if (brick.shares.empty()) return {};
  const double k = 1 / resistance;
  sum.across.fixed = k;
  for (auto& slope : sum.across.per_gap) {
    slope *= k * k;
    sum.across.fixed -= slope * kTypicalAir;
  }
  return sum;
}

Conductivity tensor(double along, double across, const BrickClass& brick) {
  const auto& n = brick.across;
  const double less = across - along;
  return {along + less * n[0] * n[0], along + less * n[1] * n[1], along + less * n[2] * n[2], less * n[0] * n[1]};
}

Conductivity at(const AffineConductivity& k, const BrickClass& brick, const ThermalCoefficients& coefficients) {
  double along = k.along.fixed;
  double across = k.across.fixed;
  for (std::size_t gap = 0; gap < kGaps.size(); ++gap) {
    along += k.along.per_gap[gap] * coefficients[gap];
    across += k.across.per_gap[gap] * coefficients[gap];
  }
  return tensor(along, across, brick);
}

/// Returns the sum of the conduction and capacity matrices of all bricks. `of_class` returns the values of a class. Two
/// nodes have an entry if a brick with non-zero values contains both. The result is symmetric to the last bit.
template <class OfClass>
SparseMatrix assemble_rows(const GyroMesh& mesh, OfClass of_class) {
  std::vector<BrickWeight> weights;
  for (const auto& brick : mesh.classes) weights.push_back(of_class(brick));
  return Rows(mesh, std::move(weights)).assemble();
}

/// Returns the film matrix for a film of 1 W/(m²·K), W/K: the sum over all film faces.
SparseMatrix assemble_film(const GyroMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  each_film_entry(mesh, [&](int n, int m, double value) { entries.emplace_back(n, m, value); });
  const auto n = static_cast<Eigen::Index>(mesh.node_count);
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Computes for each part the integral of each shape function over the part, divided by the part's volume. These
/// weights distribute a power over the part and compute its mean temperature.
template <class Add>
void each_mean_weight(const GyroMesh& mesh, const std::vector<GyroPart>& parts, Add add) {
  std::array<double, kGyroParts> volume{};
  for (const auto part : parts) volume[index(part)] = part_volume(mesh, part);
  const auto& load = hex20_integrals().load;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass& brick) {
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const double share = part_share(brick, parts[p]);
      if (share == 0) continue;
      const double scale = share * edges(mesh, i, j, k).volume() / 8 / volume[index(parts[p])];
      const auto nodes = brick_nodes(mesh, i, j, k);
      for (int n = 0; n < kHex20; ++n) add(p, nodes[n], scale * load[n]);
    }
  });
}

}  // namespace

Conductivity conductivity(const GyroModel& model, const BrickClass& brick, const ThermalCoefficients& coefficients) {
  return at(affine_conductivity(model, brick), brick, coefficients);
}

double heat_capacity(const GyroModel& model, const BrickClass& brick) {
  double sum = 0;
  for (const auto& [part, share] : brick.shares) {
    const auto& material = properties(model, part);
    sum += share * material.density_kg_per_m3 * material.specific_heat_j_per_kg_k;
  }
  return sum;
}

std::array<std::int32_t, 20> brick_nodes(const GyroMesh& mesh, int i, int j, int k) {
  std::array<std::int32_t, 20> nodes{};
  for (int n = 0; n < kHex20; ++n) {
    const auto& position = kHex20Positions[n];
    nodes[n] = mesh.nodes[mesh.point(2 * i + position[0], 2 * j + position[1], 2 * k + position[2])];
  }
  return nodes;
}

BrickPoint locate(const GyroMesh& mesh, double x, double y, double z) {
  const auto along = [](const std::vector<double>& lines, double value, int& brick) {
    constexpr double kOnFace = 1e-10;  // m
    const auto after = std::ranges::lower_bound(lines, value - kOnFace) - lines.begin();
    brick = static_cast<int>(std::clamp<std::ptrdiff_t>(after - 1, 0, std::ssize(lines) - 2));
    return std::clamp(2 * (value - lines[brick]) / (lines[brick + 1] - lines[brick]) - 1, -1.0, 1.0);
  };
  BrickPoint point;
  point.xi = along(mesh.x, x, point.i);
  point.eta = along(mesh.y, y, point.j);
  point.zeta = along(mesh.z, z, point.k);
  return point;
}

SparseMatrix assemble_capacity(const GyroModel& model, const GyroMesh& mesh) {
  const auto of_class = [&](const BrickClass& brick) { return BrickWeight{{}, heat_capacity(model, brick)}; };
  return assemble_rows(mesh, of_class);
}

Eigen::MatrixXd assemble_inputs(const GyroMesh& mesh) {
  Eigen::MatrixXd inputs = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(mesh.node_count), kThermalInputs);
  each_mean_weight(mesh, {kInputParts.begin(), kInputParts.end()}, [&](std::size_t part, int node, double value) {
    inputs(node, static_cast<Eigen::Index>(part) + 1) += value;
  });
  return inputs;
}

Eigen::VectorXd assemble_film_ambient(const GyroMesh& mesh) {
  Eigen::VectorXd area = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mesh.node_count));
  const auto& load = hex20_integrals().face_load;
  for (const auto& face : mesh.film) {
    const auto [i, j, k] = mesh.brick_position(face.brick);
    const auto nodes = brick_nodes(mesh, i, j, k);
    const double scale = face.factor * edges(mesh, i, j, k).face_area(face.face) / 4;
    for (int n = 0; n < kHex20; ++n) area[nodes[n]] += scale * load[face.face][n];
  }
  return area;
}

SparseMatrix assemble_outputs(const GyroModel& model, const GyroMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto& g = model.geometry;
  for (int t = 0; t < 8; ++t) {
    const auto& [u, v] = model.thermometers[t];
    const auto at = locate(mesh, 1e-3 * (g.cabinet[0] / 2 + u), 1e-3 * (g.cabinet[1] / 2 + v),
                           1e-3 * (g.cabinet[2] / 2 + g.block_thickness / 2));
    const auto nodes = brick_nodes(mesh, at.i, at.j, at.k);
    const auto shape = hex20_shape(at.xi, at.eta, at.zeta);
    // The mesh does not contain this location.
    if (std::ranges::count(nodes, -1) > 0) continue;
    for (int n = 0; n < kHex20; ++n)
      if (shape[n] != 0) entries.emplace_back(t, nodes[n], shape[n]);
  }
  each_mean_weight(mesh, {kOutputParts.begin(), kOutputParts.end()}, [&](std::size_t part, int node, double value) {
    entries.emplace_back(static_cast<int>(part) + 8, node, value);
  });
  SparseMatrix outputs(static_cast<Eigen::Index>(kThermalOutputs), static_cast<Eigen::Index>(mesh.node_count));
  outputs.setFromTriplets(entries.begin(), entries.end());
  return outputs;
}

ThermalSystem assemble(const GyroModel& model, const GyroMesh& mesh) {
  ThermalSystem system;
  system.capacity = assemble_capacity(model, mesh);
  const auto without_air = [&](const BrickClass& brick) { return BrickWeight{conductivity(model, brick, {})}; };
  system.conduction = assemble_rows(mesh, without_air);
  for (std::size_t gap = 0; gap < kGaps.size(); ++gap) {
    const auto of_gap = [&](const BrickClass& brick) {
      const auto k = affine_conductivity(model, brick);
      return BrickWeight{tensor(k.along.per_gap[gap], k.across.per_gap[gap], brick)};
    };
    system.conduction_per[gap] = assemble_rows(mesh, of_gap);
  }
  system.conduction_per[static_cast<std::size_t>(ThermalCoefficient::film)] = assemble_film(mesh);
  system.inputs = assemble_inputs(mesh);
  system.film_ambient = assemble_film_ambient(mesh);
  system.outputs = assemble_outputs(model, mesh);
  return system;
}

ThermalField::ThermalField(const GyroModel& model, const GyroMesh& mesh, const Eigen::VectorXd& field_c)
    : model_(model), mesh_(mesh), field_c_(field_c), parts_(make_parts(model)) {}

double ThermalField::temperature_at(double x, double y, double z) const {
  constexpr double kOutside = std::numeric_limits<double>::quiet_NaN();
  constexpr double kEdgeTolerance_m = 1e-9;  // m
  const auto off = [](const std::vector<double>& lines, double value) {
    return !(value >= lines.front() - kEdgeTolerance_m && value <= lines.back() + kEdgeTolerance_m);
  };
  if (off(mesh_.x, x) || off(mesh_.y, y) || off(mesh_.z, z)) return kOutside;
  const auto at = locate(mesh_, x, y, z);
  if (mesh_.bricks[mesh_.brick(at.i, at.j, at.k)] == 0) return kOutside;
  const auto nodes = brick_nodes(mesh_, at.i, at.j, at.k);
  const auto shape = hex20_shape(at.xi, at.eta, at.zeta);
  double sum = 0;
  for (int n = 0; n < kHex20; ++n) sum += shape[n] * field_c_[nodes[n]];
  return sum;
}

std::optional<GyroPart> ThermalField::part_at(double x, double y, double z) const {
  return gyrotherm::thermal::part_at(model_, parts_, 1e3 * x, 1e3 * y, 1e3 * z);
}

}  // namespace gyrotherm::thermal
