#include "thermal/assembly.hpp"

#include <algorithm>
#include <cassert>

#include "thermal/hex20.hpp"
#include "thermal/row_assembly.hpp"

namespace gyrotherm {
namespace {

constexpr std::array<GyroPart, 3> kGaps{GyroPart::air_lid, GyroPart::air_side, GyroPart::air_base};

/// Which part each output after the thermometers is the mean of, in their order.
constexpr std::array<GyroPart, kThermalOutputs - 8> kMeanOf{
    GyroPart::shell,    GyroPart::gain_left, GyroPart::gain_right, GyroPart::passive_bore, GyroPart::preamplifier,
    GyroPart::mirror_b, GyroPart::mirror_c,  GyroPart::mirror_f,   GyroPart::mirror_h,     GyroPart::block};
/// … and which part each input after the ambient heats.
constexpr std::array<GyroPart, kThermalInputs - 1> kHeated{
    GyroPart::gain_left, GyroPart::gain_right, GyroPart::preamplifier, GyroPart::ballast_left, GyroPart::ballast_right};

const MaterialProperties& properties(const GyroModel& model, GyroPart part) {
  return model.materials[static_cast<std::size_t>(material_of(part))];
}

/// One value as c₀ + Σ c_m k_m over the gaps' conductivities.
struct Affine {
  double fixed{};
  std::array<double, kGaps.size()> per_gap{};
};
struct AffineConductivity {
  Affine along;
  Affine across;
};

constexpr double kUsualAir = 0.03;  // W/(m·K), where the tangent across a face is taken

AffineConductivity affine_conductivity(const GyroModel& model, const BrickClass& brick) {
  AffineConductivity sum;
  double resistance = 0;
  for (const auto& [part, share] : brick.shares) {
    const auto gap = std::ranges::find(kGaps, part);
    const bool air = gap != kGaps.end();
    const double k = air ? kUsualAir : properties(model, part).conductivity_w_per_m_k;
    (air ? sum.along.per_gap[gap - kGaps.begin()] : sum.along.fixed) += air ? share : share * k;
    resistance += share / k;
    if (air) sum.across.per_gap[gap - kGaps.begin()] = share / (k * k);
  }
  if (brick.shares.empty()) return {};
  const double k = 1 / resistance;
  sum.across.fixed = k;
  for (auto& slope : sum.across.per_gap) {
    slope *= k * k;
    sum.across.fixed -= slope * kUsualAir;
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

BrickWeight weight(const Conductivity& k) { return {k.xx, k.yy, k.zz, k.xy, 0}; }

template <class OfClass>
std::vector<BrickWeight> weights(const GyroMesh& mesh, OfClass of_class) {
  std::vector<BrickWeight> values;
  for (const auto& brick : mesh.classes) values.push_back(of_class(brick));
  return values;
}

template <class Visit>
void each_brick(const GyroMesh& mesh, Visit visit) {
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i)
        if (const auto& brick = mesh.classes[mesh.bricks[mesh.brick(i, j, k)]]; !brick.shares.empty())
          visit(i, j, k, brick);
}

/// For each part, the integral of every shape function over it divided by its volume: what spreads a watt over the
/// part, and what takes its mean.
template <class Add>
void each_mean(const GyroMesh& mesh, const std::vector<GyroPart>& parts, Add add) {
  std::array<double, kGyroParts> volume{};
  for (const auto part : parts) volume[index(part)] = volume_of(mesh, part);
  const auto& load = hex20_integrals().load;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass& brick) {
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const double share = share_of(brick, parts[p]);
      if (share == 0) continue;
      const double scale = share * edges(mesh, i, j, k).volume() / 8 / volume[index(parts[p])];
      const auto nodes = nodes_of(mesh, i, j, k);
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

std::array<std::int32_t, 20> nodes_of(const GyroMesh& mesh, int i, int j, int k) {
  std::array<std::int32_t, 20> nodes{};
  for (int n = 0; n < kHex20; ++n) {
    const auto& place = kHex20Places[n];
    nodes[n] = mesh.nodes[mesh.point(2 * i + place[0], 2 * j + place[1], 2 * k + place[2])];
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

SparseMatrix assemble_conduction(const GyroModel& model, const GyroMesh& mesh,
                                 const ThermalCoefficients& coefficients) {
  const auto of_class = [&](const BrickClass& brick) { return weight(conductivity(model, brick, coefficients)); };
  auto matrix = assemble_rows(mesh, weights(mesh, of_class));
  add_film(mesh, coefficients[static_cast<std::size_t>(ThermalCoefficient::film)], matrix);
  return matrix;
}

SparseMatrix assemble_capacity(const GyroModel& model, const GyroMesh& mesh) {
  const auto of_class = [&](const BrickClass& brick) { return BrickWeight{.capacity = heat_capacity(model, brick)}; };
  return assemble_rows(mesh, weights(mesh, of_class));
}

Eigen::MatrixXd assemble_inputs(const GyroMesh& mesh) {
  Eigen::MatrixXd inputs = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(mesh.node_count), kThermalInputs);
  each_mean(mesh, {kHeated.begin(), kHeated.end()}, [&](std::size_t part, int node, double value) {
    inputs(node, static_cast<Eigen::Index>(part) + 1) += value;
  });
  return inputs;
}

Eigen::VectorXd assemble_film_ambient(const GyroMesh& mesh) {
  Eigen::VectorXd area = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mesh.node_count));
  const auto& load = hex20_integrals().face_load;
  for (const auto& face : mesh.film) {
    const auto b = static_cast<int>(face.brick);
    const int i = b % mesh.nx();
    const int j = b / mesh.nx() % mesh.ny();
    const int k = b / mesh.nx() / mesh.ny();
    const auto nodes = nodes_of(mesh, i, j, k);
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
    const auto nodes = nodes_of(mesh, at.i, at.j, at.k);
    const auto shape = hex20_shape(at.xi, at.eta, at.zeta);
    if (std::ranges::count(nodes, -1) > 0) continue;  // a mesh without that place
    for (int n = 0; n < kHex20; ++n)
      if (shape[n] != 0) entries.emplace_back(t, nodes[n], shape[n]);
  }
  each_mean(mesh, {kMeanOf.begin(), kMeanOf.end()}, [&](std::size_t part, int node, double value) {
    entries.emplace_back(static_cast<int>(part) + 8, node, value);
  });
  SparseMatrix outputs(static_cast<Eigen::Index>(kThermalOutputs), static_cast<Eigen::Index>(mesh.node_count));
  outputs.setFromTriplets(entries.begin(), entries.end());
  return outputs;
}

ThermalSystem assemble(const GyroModel& model, const GyroMesh& mesh) {
  ThermalSystem system;
  system.capacity = assemble_capacity(model, mesh);
  const auto without_air = [&](const BrickClass& brick) { return weight(conductivity(model, brick, {})); };
  system.conduction = assemble_rows(mesh, weights(mesh, without_air));
  for (std::size_t gap = 0; gap < kGaps.size(); ++gap) {
    const auto of_gap = [&](const BrickClass& brick) {
      const auto k = affine_conductivity(model, brick);
      return weight(tensor(k.along.per_gap[gap], k.across.per_gap[gap], brick));
    };
    system.conduction_per[gap] = assemble_rows(mesh, weights(mesh, of_gap));
  }
  system.conduction_per[static_cast<std::size_t>(ThermalCoefficient::film)] = assemble_film(mesh);
  system.inputs = assemble_inputs(mesh);
  system.film_ambient = assemble_film_ambient(mesh);
  system.outputs = assemble_outputs(model, mesh);
  return system;
}

}  // namespace gyrotherm
