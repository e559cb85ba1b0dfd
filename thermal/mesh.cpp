#include "thermal/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "thermal/block_film.hpp"
#include "thermal/brick_shares.hpp"
#include "thermal/gyro_parts.hpp"
#include "thermal/hex20.hpp"

namespace gyrotherm {
namespace {

constexpr int kSteps = 512;  // of a share

/// Of the shares, and of the direction across: 0 none, 1 upright, from 2 on angles in the plan.
using Steps = std::array<int, kGyroParts + 1>;
constexpr int kAngles = 128;  // in half a turn
constexpr int kUpright = 1;

int direction_step(const std::array<double, 3>& across) {
  const double plan = std::hypot(across[0], across[1]);
  if (plan == 0 && across[2] == 0) return 0;
  if (std::abs(across[2]) > plan) return kUpright;
  const auto turns = std::lround(std::atan2(across[1], across[0]) / std::numbers::pi * kAngles);
  return 2 + static_cast<int>((turns + kAngles) % kAngles);
}

/// Shares in whole steps; where they fill the brick, so do the steps. The small addend makes a share that lies on the
/// border but for rounding go the same way on both sides of the gyro.
Steps steps_of(const BrickContents& contents, bool fills) {
  Steps steps{};
  int sum = 0;
  for (std::size_t part = 0; part < kGyroParts; ++part) {
    steps[part] = static_cast<int>(std::floor(contents.share[part] * kSteps + 0.5 + 1e-6));
    sum += steps[part];
  }
  if (fills && sum > 0) {
    const auto largest = std::max_element(steps.begin(), steps.begin() + kGyroParts);
    *largest += kSteps - sum;
  }
  steps.back() = direction_step(contents.across);
  return steps;
}

std::array<double, 3> direction(int step) {
  if (step == 0) return {};
  if (step == kUpright) return {0, 0, 1};
  const double angle = (step - 2) * std::numbers::pi / kAngles;
  return {std::cos(angle), std::sin(angle), 0};
}

void classify(const std::vector<BrickContents>& contents, bool fills, GyroMesh& mesh) {
  std::map<Steps, std::uint16_t> known{{Steps{}, 0}};
  mesh.classes.assign(1, {});
  mesh.bricks.reserve(contents.size());
  for (const auto& brick : contents) {
    const auto steps = steps_of(brick, fills);
    const auto [entry, added] = known.try_emplace(steps, static_cast<std::uint16_t>(mesh.classes.size()));
    if (added) {
      BrickClass made;
      for (std::size_t part = 0; part < kGyroParts; ++part)
        if (steps[part] > 0)
          made.shares.push_back({static_cast<GyroPart>(part), static_cast<double>(steps[part]) / kSteps});
      if (made.shares.size() > 1) made.across = direction(steps.back());
      mesh.classes.push_back(std::move(made));
    }
    mesh.bricks.push_back(entry->second);
  }
}

std::vector<FilmFace> shell_film(const GyroMesh& mesh) {
  std::vector<FilmFace> film;
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i) {
        const std::array<bool, kBrickFaces> outer{i == 0, i == mesh.nx() - 1, j == 0, j == mesh.ny() - 1,
                                                  k == 0, k == mesh.nz() - 1};
        for (int face = 0; face < kBrickFaces; ++face)
          if (outer[face]) film.push_back({mesh.brick(i, j, k), face, 1});
      }
  return film;
}

std::vector<double> in_metres(const std::vector<double>& lines_mm) {
  std::vector<double> lines;
  for (const double line : lines_mm) lines.push_back(1e-3 * line);
  return lines;
}

}  // namespace

double edge_mm(MeshSize size) {
  switch (size) {
    case MeshSize::coarse: return 4.6;
    case MeshSize::medium: return 2.9;
    case MeshSize::fine: break;
  }
  return 2.1;
}

GyroMesh make_mesh(const GyroModel& model, MeshSize size) { return make_mesh(model, edge_mm(size)); }

GyroMesh make_mesh(const GyroModel& model, double edge_mm) {
  const auto parts = parts_of(model);
  const auto lines = grid_lines(model, parts, edge_mm);
  auto contents = brick_contents(model, parts, lines);
  const bool full = model.mode == GyroMode::full;
  if (!full) consolidate(contents, lines);
  GyroMesh mesh;
  mesh.x = in_metres(lines.x);
  mesh.y = in_metres(lines.y);
  mesh.z = in_metres(lines.z);
  classify(contents, full, mesh);
  mesh.film = full ? shell_film(mesh) : block_film(parts, lines, contents);
  number_nodes(mesh);
  return mesh;
}

void number_nodes(GyroMesh& mesh) {
  const std::size_t points = static_cast<std::size_t>(2 * mesh.nx() + 1) * (2 * mesh.ny() + 1) * (2 * mesh.nz() + 1);
  mesh.nodes.assign(points, -1);
  mesh.element_count = 0;
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i) {
        if (mesh.bricks[mesh.brick(i, j, k)] == 0) continue;
        ++mesh.element_count;
        for (const auto& place : kHex20Places)
          mesh.nodes[mesh.point(2 * i + place[0], 2 * j + place[1], 2 * k + place[2])] = 0;
      }
  std::int32_t number = 0;
  for (auto& node : mesh.nodes)
    if (node == 0) node = number++;
  mesh.node_count = static_cast<std::size_t>(number);
}

double volume_of(const GyroMesh& mesh, GyroPart part) {
  double volume = 0;
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i)
        volume += share_of(mesh.classes[mesh.bricks[mesh.brick(i, j, k)]], part) * edges(mesh, i, j, k).volume();
  return volume;
}

double share_of(const BrickClass& brick, GyroPart part) {
  const auto found = std::ranges::find(brick.shares, part, &PartShare::part);
  return found == brick.shares.end() ? 0 : found->share;
}

}  // namespace gyrotherm
