// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/mesh.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "simulator/thermal/gyro_parts.hpp"
#include "simulator/thermal/hex20.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr double kCoincidence = 1e-6;  // mm

std::vector<double> divide_intervals(std::vector<double> marks, double edge_mm) {
  std::ranges::sort(marks);
  std::vector<double> lines{marks.front()};
  for (const double mark : marks) {
    const double from = lines.back();
    if (mark - from < kCoincidence) continue;
    const auto pieces = std::max(1L, std::lround((mark - from) / edge_mm));
    for (long piece = 1; piece < pieces; ++piece) {
      lines.push_back(from + (mark - from) * static_cast<double>(piece) / static_cast<double>(pieces));
    }
    lines.push_back(mark);
  }
  return lines;
}

/// The grid lines, with positions and lengths of the bricks between them, mm.
struct GridLines {
  std::vector<double> x, y, z;

  [[nodiscard]] int nx() const { return static_cast<int>(x.size()) - 1; }
  [[nodiscard]] int ny() const { return static_cast<int>(y.size()) - 1; }
  [[nodiscard]] int nz() const { return static_cast<int>(z.size()) - 1; }
  [[nodiscard]] std::size_t bricks() const { return static_cast<std::size_t>(nx()) * ny() * nz(); }
  [[nodiscard]] BrickIndex brick_position(std::size_t brick) const { return brick_index(brick, nx(), ny()); }
  [[nodiscard]] bool contains(BrickIndex p) const {
    return p.i >= 0 && p.j >= 0 && p.k >= 0 && p.i < nx() && p.j < ny() && p.k < nz();
  }
  [[nodiscard]] std::size_t brick(BrickIndex p) const {
    return (static_cast<std::size_t>(p.k) * ny() + p.j) * nx() + p.i;
  }
  [[nodiscard]] PlanRectangle plan(BrickIndex p) const { return {x[p.i], x[p.i + 1], y[p.j], y[p.j + 1]}; }
  [[nodiscard]] double height(BrickIndex p) const { return z[p.k + 1] - z[p.k]; }
  [[nodiscard]] double plan_area(BrickIndex p) const {
    const auto r = plan(p);
    return (r.x1 - r.x0) * (r.y1 - r.y0);
  }
  [[nodiscard]] double face_area(BrickIndex p, int face) const {
    const auto r = plan(p);
    return face < 2 ? (r.y1 - r.y0) * height(p) : face < 4 ? (r.x1 - r.x0) * height(p) : plan_area(p);
  }
  /// Returns the brick of layer k that contains a point.
  [[nodiscard]] BrickIndex at(PlanPoint point, int k) const {
    const auto find = [](const std::vector<double>& lines, double value) {
      return static_cast<int>(std::ranges::upper_bound(lines, value) - lines.begin()) - 1;
    };
    return {find(x, point.x), find(y, point.y), k};
  }
};

/// Content of a brick, and the share of its plan that is solid, 0 … 1.
struct BrickContents {
  std::array<double, kGyroParts> share{};
  double plan_share{};
  /// A vector across the face that cuts the brick; zero: none.
  std::array<double, 3> across{};
  /// True if the brick lies inside one box, or if no face cuts it.
  bool whole = true;
};

/// Returns the share of [a0, a1] inside [b0, b1], 0 … 1.
double overlap(double a0, double a1, double b0, double b1) {
  return std::max(0.0, std::min(a1, b1) - std::max(a0, b0)) / (a1 - a0);
}

/// Share of a rectangle that a shape covers, 0 … 1, and the integral of the shape's outward normal over its edge inside
/// the rectangle, mm.
struct Cover {
  double share{};
  PlanPoint outward{};

  Cover& operator+=(const Cover& other) {
    share += other.share;
    outward = {outward.x + other.outward.x, outward.y + other.outward.y};
    return *this;
  }
  friend Cover operator-(const Cover& a, const Cover& b) {
    return {a.share - b.share, {a.outward.x - b.outward.x, a.outward.y - b.outward.y}};
  }
};

/// Returns the cover of a rectangle by a prism. The outward normals of a closed outline add up to zero, so the integral
/// over the inner edges is minus the integral over the rectangle's sides.
Cover compute_cover(const PlanRectangle& r, const Prism& prism) {
  const auto box = bounds(prism.plan);
  if (box.x1 <= r.x0 || box.x0 >= r.x1 || box.y1 <= r.y0 || box.y0 >= r.y1) return {};
  const auto shared = intersection(prism.plan, to_outline(r));
  Cover cover{area(shared) / ((r.x1 - r.x0) * (r.y1 - r.y0)), {}};
  for (std::size_t i = 0; i < shared.size(); ++i) {
    const auto a = shared[i];
    const auto b = shared[(i + 1) % shared.size()];
    const auto on = [&](double from, double to, double side) {
      return std::abs(from - side) < kCoincidence && std::abs(to - side) < kCoincidence;
    };
    if (on(a.x, b.x, r.x0) || on(a.x, b.x, r.x1)) cover.outward.x -= b.y - a.y;
    if (on(a.y, b.y, r.y0) || on(a.y, b.y, r.y1)) cover.outward.y += b.x - a.x;
  }
  return cover;
}

/// Cover of a brick's plan by the upright parts, regardless of height.
struct Column {
  /// Excludes the hole.
  Cover block;
  std::array<Cover, 4> mirrors;
  /// Excludes the hub.
  Cover dither;
  Cover hub;
  double area_mm2{};
  /// True inside the cabinet's walls.
  bool inside{};
};

Column make_column(const GyroParts& parts, const PlanRectangle& r) {
  Column column;
  column.area_mm2 = (r.x1 - r.x0) * (r.y1 - r.y0);
  const auto hole = compute_cover(r, parts.hole);
  column.hub = compute_cover(r, parts.hub);
  column.dither = hole - column.hub;
  column.block = compute_cover(r, parts.block) - hole;
  for (std::size_t m = 0; m < 4; ++m) column.mirrors[m] = compute_cover(r, parts.mirrors[m]);
  const double x = (r.x0 + r.x1) / 2;
  const double y = (r.y0 + r.y1) / 2;
  column.inside = x > parts.inside.x0 && x < parts.inside.x1 && y > parts.inside.y0 && y < parts.inside.y1;
  return column;
}

BrickContents uniform_contents(GyroPart part) {
  BrickContents contents;
  contents.share[index(part)] = 1;
  contents.plan_share = 1;
  return contents;
}

/// Vector across the face that cuts the brick; zero: none.
std::array<double, 3> cut_direction(const GyroParts& parts, const Column& column, double z0, double z1) {
  std::array<double, 3> sum{};
  double filled = 0;
  const auto add = [&](const Prism& prism, const Cover& plan) {
    const double height = overlap(z0, z1, prism.z0, prism.z1);
    filled += plan.share * height;
    sum[0] += plan.outward.x * height * (z1 - z0);
    sum[1] += plan.outward.y * height * (z1 - z0);
    const double at_top = z1 > prism.z0 && z1 <= prism.z1 ? 1 : 0;
    const double at_bottom = z0 >= prism.z0 && z0 < prism.z1 ? 1 : 0;
    sum[2] += plan.share * (at_bottom - at_top) * column.area_mm2;
  };
  const auto cut = [&] { return filled > 1e-9 && filled < 1 - 1e-9; };
  add(parts.block, column.block);
  for (std::size_t m = 0; m < 4; ++m) add(parts.mirrors[m], column.mirrors[m]);
  if (cut()) return sum;
  for (const bool hub : {true, false}) {
    sum = {};
    filled = 0;
    add(hub ? parts.hub : parts.dither, hub ? column.hub : column.dither);
    if (cut()) return sum;
  }
  return {};
}

/// Returns the content of a brick with upright parts. The remainder is air in full mode and empty in block mode.
BrickContents mixed_contents(const GyroModel& model, const GyroParts& parts, const Column& column, double z0,
                             double z1) {
  BrickContents contents;
  const auto add = [&](const Prism& prism, const Cover& plan, bool solid) {
    const double height = overlap(z0, z1, prism.z0, prism.z1);
    contents.share[index(prism.part)] += plan.share * height;
    if (solid && height > 0) contents.plan_share += plan.share;
  };
  const bool full = model.mode == GyroMode::full;
  add(parts.block, column.block, true);
  for (std::size_t m = 0; m < 4; ++m) add(parts.mirrors[m], column.mirrors[m], true);
  if (full) {
    add(parts.dither, column.dither, false);
    add(parts.hub, column.hub, false);
  }
  double filled = 0;
  int kinds = 0;
  for (auto& share : contents.share) {
    if (share < 1e-9) share = 0;
    filled += share;
    kinds += share > 0 ? 1 : 0;
  }
  contents.whole = kinds == 0 || (kinds == 1 && filled > 1 - 1e-9);
  if (full) contents.share[index(air_at(model, (z0 + z1) / 2))] += std::max(0.0, 1 - filled);
  if (!contents.whole) contents.across = cut_direction(parts, column, z0, z1);
  return contents;
}

constexpr std::array<BrickIndex, kBrickFaces> kNeighbours{
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

double solid_share(const BrickContents& brick) { return std::accumulate(brick.share.begin(), brick.share.end(), 0.0); }

// Number of steps into which a share is rounded.
constexpr int kShareSteps = 512;

/// Rounds a share to whole steps. The small addend rounds shares on a rounding boundary in the same direction on both
/// sides of the gyro.
int share_steps(double share) { return static_cast<int>(std::floor(share * kShareSteps + 0.5 + 1e-6)); }

/// Returns whether a brick remains after its shares were rounded.
bool is_solid(const BrickContents& brick) {
  return std::ranges::any_of(brick.share, [](double share) { return share_steps(share) > 0; });
}

/// An upright wall from a to b, with the outside on its right.
struct Wall {
  PlanPoint a, b;
  double z0, z1;
};

PlanPoint between(PlanPoint a, PlanPoint b, double t) { return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}; }
double distance(PlanPoint a, PlanPoint b) { return std::hypot(b.x - a.x, b.y - a.y); }

/// Adds a 45° face of the block without the area that its mirror covers.
void add_slanted(const Wall& face, const Prism& mirror, std::vector<Wall>& walls) {
  const double half = distance(mirror.plan[3], mirror.plan[0]) / distance(face.a, face.b) / 2;
  const auto from = between(face.a, face.b, 0.5 - half);
  const auto to = between(face.a, face.b, 0.5 + half);
  walls.push_back({face.a, from, face.z0, face.z1});
  walls.push_back({from, to, face.z0, mirror.z0});
  walls.push_back({from, to, mirror.z1, face.z1});
  walls.push_back({to, face.b, face.z0, face.z1});
}

std::vector<Wall> make_walls(const GyroParts& parts) {
  std::vector<Wall> walls;
  const auto& plan = parts.block.plan;
  // The 45° faces, counter-clockwise from +x +y.
  constexpr std::array<std::size_t, 4> kMirrorOfFace{1, 0, 2, 3};
  for (std::size_t edge = 0; edge < plan.size(); ++edge) {
    const Wall wall{plan[edge], plan[(edge + 1) % plan.size()], parts.block.z0, parts.block.z1};
    if (edge % 2 == 1)
      add_slanted(wall, parts.mirrors[kMirrorOfFace[edge / 2]], walls);
    else
      walls.push_back(wall);
  }
  for (const auto& mirror : parts.mirrors)
    // The fourth edge lies on the block.
    for (std::size_t edge = 0; edge < 3; ++edge)
      walls.push_back({mirror.plan[edge], mirror.plan[edge + 1], mirror.z0, mirror.z1});
  for (const auto& box : parts.boxes) {
    if (is_gas(box.part)) continue;
    for (std::size_t edge = 0; edge < 4; ++edge)
      walls.push_back({box.plan[edge], box.plan[(edge + 1) % 4], box.z0, box.z1});
  }
  std::erase_if(walls, [](const Wall& w) { return distance(w.a, w.b) < 1e-9 || w.z1 - w.z0 < 1e-9; });
  return walls;
}

class WallFilm {
 public:
  WallFilm(const GridLines& lines, const std::vector<BrickContents>& contents)
      : grid_(lines), contents_(contents), area_(grid_.bricks() * kBrickFaces) {}

  void add_levels() {
    for (std::size_t b = 0; b < grid_.bricks(); ++b) {
      const auto p = grid_.brick_position(b);
      for (const int face : {4, 5})
        if (is_exposed(p, face)) area_[b * kBrickFaces + face] = contents_[b].plan_share * grid_.plan_area(p);
    }
  }

  void add(const Wall& wall) {
    std::vector<double> cuts{0, 1};
    const auto cross = [&](const std::vector<double>& lines, double from, double to) {
      if (std::abs(to - from) < 1e-9) return;
      for (const double line : lines)
        if (const double t = (line - from) / (to - from); t > 0 && t < 1) cuts.push_back(t);
    };
    cross(grid_.x, wall.a.x, wall.b.x);
    cross(grid_.y, wall.a.y, wall.b.y);
    std::ranges::sort(cuts);
    const double length = distance(wall.a, wall.b);
    const PlanPoint out{(wall.b.y - wall.a.y) / length, (wall.a.x - wall.b.x) / length};
    for (std::size_t c = 1; c < cuts.size(); ++c) {
      const double piece = (cuts[c] - cuts[c - 1]) * length;
      if (piece < 1e-9) continue;
      const auto middle = between(wall.a, wall.b, (cuts[c] + cuts[c - 1]) / 2);
      for (int k = 0; k < grid_.nz(); ++k) {
        const double height = std::min(grid_.z[k + 1], wall.z1) - std::max(grid_.z[k], wall.z0);
        if (height > 1e-9) put(piece * height, middle, out, k);
      }
    }
  }

  [[nodiscard]] std::vector<FilmFace> faces() const {
    std::vector<FilmFace> found;
    for (std::size_t b = 0; b < grid_.bricks(); ++b)
      for (int face = 0; face < kBrickFaces; ++face)
        if (const double area = area_[b * kBrickFaces + face]; area > 0)
          found.push_back({b, face, area / grid_.face_area(grid_.brick_position(b), face)});
    return found;
  }

 private:
  [[nodiscard]] bool has_solid(BrickIndex p) const { return grid_.contains(p) && is_solid(contents_[grid_.brick(p)]); }
  [[nodiscard]] static BrickIndex neighbour(BrickIndex p, int face) {
    return {p.i + kNeighbours[face].i, p.j + kNeighbours[face].j, p.k + kNeighbours[face].k};
  }
  [[nodiscard]] bool is_exposed(BrickIndex p, int face) const { return has_solid(p) && !has_solid(neighbour(p, face)); }

  /// Adds the area of a piece of wall to the brick face that it covers. `middle` is on the wall, `out` is its outward
  /// direction.
  void put(double area, PlanPoint middle, PlanPoint out, int k) {
    const auto brick = grid_.at({middle.x - 1e-6 * out.x, middle.y - 1e-6 * out.y}, k);
    int flat = -1;
    for (int face = 0; face < 4; ++face)
      if (out.x * kNeighbours[face].i + out.y * kNeighbours[face].j > 1 - 1e-9) flat = face;
    if (flat >= 0 && has_solid(brick)) {
      // A face that is not exposed touches another part and has no film.
      if (is_exposed(brick, flat)) area_[grid_.brick(brick) * kBrickFaces + flat] += area;
      return;
    }
    const int most = std::max(grid_.nx(), grid_.ny());
    for (int reach = std::min(2, most);; reach = std::min(2 * reach, most)) {
      if (spread(area, middle, out, brick, reach)) return;
      if (reach == most) break;
    }
    assert(false && "no brick of this layer has a face towards the outside of the wall");
  }

  bool spread(double area, PlanPoint middle, PlanPoint out, BrickIndex around, int reach) {
    struct Candidate {
      std::size_t face;
      double weight;
    };
    std::vector<Candidate> candidates;
    double sum = 0;
    for (int dj = -reach; dj <= reach; ++dj) {
      for (int di = -reach; di <= reach; ++di) {
        const BrickIndex p{around.i + di, around.j + dj, around.k};
        if (!has_solid(p)) continue;
        const auto r = grid_.plan(p);
        for (int face = 0; face < 4; ++face) {
          const double facing = out.x * kNeighbours[face].i + out.y * kNeighbours[face].j;
          if (facing < 0.1 || !is_exposed(p, face)) continue;
          const PlanPoint centre{(r.x0 + r.x1 + kNeighbours[face].i * (r.x1 - r.x0)) / 2,
                                 (r.y0 + r.y1 + kNeighbours[face].j * (r.y1 - r.y0)) / 2};
          const double d = distance(centre, middle);
          const double scale = (r.x1 - r.x0) * (r.x1 - r.x0) + (r.y1 - r.y0) * (r.y1 - r.y0);
          const double weight = facing * grid_.face_area(p, face) * std::exp(-8 * d * d / (scale * reach * reach));
          candidates.push_back({grid_.brick(p) * kBrickFaces + face, weight});
          sum += weight;
        }
      }
    }
    if (sum < 1e-12) return false;
    for (const auto& [face, weight] : candidates) area_[face] += area * weight / sum;
    return true;
  }

  const GridLines& grid_;
  const std::vector<BrickContents>& contents_;
  // mm², by brick and face.
  std::vector<double> area_;
};

/// Rounded shares and rounded direction across the face. Direction 0: no face; 1: upright; from 2 on: angles in the
/// plan.
using Steps = std::array<int, kGyroParts + 1>;
// Steps in half a turn.
constexpr int kAngles = 128;
constexpr int kUpright = 1;

int direction_step(const std::array<double, 3>& across) {
  const double plan = std::hypot(across[0], across[1]);
  if (plan == 0 && across[2] == 0) return 0;
  if (std::abs(across[2]) > plan) return kUpright;
  const auto turns = std::lround(std::atan2(across[1], across[0]) / std::numbers::pi * kAngles);
  return 2 + static_cast<int>((turns + kAngles) % kAngles);
}

/// Rounds shares to whole steps. If the shares fill the brick, the rounded shares fill it too. If all shares round to
/// 0, the brick is empty and has no direction.
Steps round_shares(const BrickContents& contents, bool fills) {
  Steps steps{};
  int sum = 0;
  for (std::size_t part = 0; part < kGyroParts; ++part) {
    steps[part] = share_steps(contents.share[part]);
    sum += steps[part];
  }
  if (sum == 0) return {};
  if (fills) {
    const auto largest = std::max_element(steps.begin(), steps.begin() + kGyroParts);
    *largest += kShareSteps - sum;
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
    const auto steps = round_shares(brick, fills);
    const auto [entry, added] = known.try_emplace(steps, static_cast<std::uint16_t>(mesh.classes.size()));
    if (added) {
      BrickClass made;
      for (std::size_t part = 0; part < kGyroParts; ++part)
        if (steps[part] > 0)
          made.shares.push_back({static_cast<GyroPart>(part), static_cast<double>(steps[part]) / kShareSteps});
      if (made.shares.size() > 1 || !fills) made.across = direction(steps.back());
      mesh.classes.push_back(std::move(made));
    }
    mesh.bricks.push_back(entry->second);
  }
}

std::vector<FilmFace> shell_film(const GyroMesh& mesh) {
  std::vector<FilmFace> film;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass&) {
    const std::array<bool, kBrickFaces> outer{i == 0, i == mesh.nx() - 1, j == 0, j == mesh.ny() - 1,
                                              k == 0, k == mesh.nz() - 1};
    for (int face = 0; face < kBrickFaces; ++face)
      if (outer[face]) film.push_back({mesh.brick(i, j, k), face, 1});
  });
  return film;
}

std::vector<double> to_metres(const std::vector<double>& lines_mm) {
  std::vector<double> lines;
  for (const double line : lines_mm) lines.push_back(1e-3 * line);
  return lines;
}

/// Returns grid lines on the faces of all boxes, on flat faces, hole and hub, mm. Each interval is divided evenly into
/// the nearest whole number of pieces of `edge_mm`, at least one.
GridLines grid_lines(const GyroModel& model, const GyroParts& parts, double edge_mm) {
  const auto& g = model.geometry;
  const double cx = g.cabinet[0] / 2;
  const double cy = g.cabinet[1] / 2;
  std::vector<double> x{cx};
  std::vector<double> y{cy};
  std::vector<double> z;
  const auto mark = [&](const Prism& prism, bool levels) {
    const auto box = bounds(prism.plan);
    x.insert(x.end(), {box.x0, box.x1});
    y.insert(y.end(), {box.y0, box.y1});
    if (levels) z.insert(z.end(), {prism.z0, prism.z1});
  };
  for (const auto& box : parts.boxes) mark(box, true);
  mark(parts.block, true);
  for (const double radius : {g.hole_diameter / 2, g.hub_diameter / 2}) {
    x.insert(x.end(), {cx - radius, cx + radius});
    y.insert(y.end(), {cy - radius, cy + radius});
  }
  if (model.mode == GyroMode::full) {
    x.insert(x.end(), {0, parts.inside.x0, parts.inside.x1, g.cabinet[0]});
    y.insert(y.end(), {0, parts.inside.y0, parts.inside.y1, g.cabinet[1]});
    z.insert(z.end(), {0, parts.inside_z0, parts.inside_z1, g.cabinet[2]});
    z.insert(z.end(), {parts.dither.z0, parts.dither.z1, parts.hub.z1});
  } else {
    for (const auto& prism : parts.mirrors) {
      const auto box = bounds(prism.plan);
      if (box.x1 > cx + g.block_width / 2) x.insert(x.end(), {2 * cx - box.x1, box.x1});
      if (box.y1 > cy + g.block_width / 2) y.insert(y.end(), {2 * cy - box.y1, box.y1});
    }
  }
  return {divide_intervals(x, edge_mm), divide_intervals(y, edge_mm), divide_intervals(z, edge_mm)};
}

/// Returns the contents by brick index. Shares add up to 1 in full mode and to at most 1 in block mode.
std::vector<BrickContents> brick_contents(const GyroModel& model, const GyroParts& parts, const GridLines& lines) {
  const auto nx = lines.x.size() - 1;
  const auto ny = lines.y.size() - 1;
  const auto nz = lines.z.size() - 1;
  std::vector<BrickContents> all(nx * ny * nz);
  for (std::size_t j = 0; j < ny; ++j) {
    for (std::size_t i = 0; i < nx; ++i) {
      const PlanRectangle r{lines.x[i], lines.x[i + 1], lines.y[j], lines.y[j + 1]};
      const PlanPoint middle{(r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2};
      const auto column = make_column(parts, r);
      std::vector<const Prism*> here;
      for (const auto& box : parts.boxes)
        if (contains(box.plan, middle)) here.push_back(&box);
      for (std::size_t k = 0; k < nz; ++k) {
        const double z = (lines.z[k] + lines.z[k + 1]) / 2;
        auto& contents = all[(k * ny + j) * nx + i];
        const auto box = std::ranges::find_if(here, [&](const Prism* prism) { return z > prism->z0 && z < prism->z1; });
        if (box != here.end())
          contents = uniform_contents((*box)->part);
        else if (model.mode == GyroMode::full && (!column.inside || z < parts.inside_z0 || z > parts.inside_z1))
          contents = uniform_contents(GyroPart::shell);
        else
          contents = mixed_contents(model, parts, column, lines.z[k], lines.z[k + 1]);
      }
    }
  }
  return all;
}

/// Smallest solid share of a brick's plan in block mode. A larger limit leaves coarser steps along slanted and round
/// faces, which obstruct the heat flow near them. A smaller limit attaches film to almost empty bricks.
constexpr double kLeastSolid = 0.25;

/// Drops cut bricks whose solid share is below kLeastSolid. Their content goes to the fullest of the four level
/// neighbours that remain. Volumes and plan areas keep their sums.
void merge_sparse_bricks(std::vector<BrickContents>& contents, const GridLines& grid) {
  const auto before = contents;
  const auto stays = [&](const BrickContents& brick) { return brick.whole || brick.plan_share >= kLeastSolid; };
  for (std::size_t b = 0; b < contents.size(); ++b) {
    if (stays(before[b]) || solid_share(before[b]) == 0) continue;
    const auto here = grid.brick_position(b);
    std::size_t best = b;
    double fullest = kLeastSolid - 1e-9;
    for (int face = 0; face < 4; ++face) {
      const BrickIndex p{here.i + kNeighbours[face].i, here.j + kNeighbours[face].j, here.k};
      if (!grid.contains(p)) continue;
      const auto& neighbour = before[grid.brick(p)];
      double glass = 0;
      for (std::size_t part = 0; is_glass(static_cast<GyroPart>(part)); ++part) glass += neighbour.share[part];
      if (!stays(neighbour) || glass == 0 || neighbour.plan_share < fullest + 1e-9) continue;
      fullest = neighbour.plan_share;
      best = grid.brick(p);
    }
    if (best == b) continue;
    const double ratio = grid.plan_area(here) / grid.plan_area(grid.brick_position(best));
    for (std::size_t part = 0; part < kGyroParts; ++part) contents[best].share[part] += ratio * before[b].share[part];
    contents[best].plan_share += ratio * before[b].plan_share;
    contents[b] = {};
  }
}

/// Returns the film on the block, its mirrors and attached parts, by brick and face: level faces with the plan area of
/// the brick, flat upright faces at their wall, slanted walls distributed over the nearby brick faces. The hole's wall
/// has no film. The sums are the true areas.
std::vector<FilmFace> block_film(const GyroParts& parts, const GridLines& lines,
                                 const std::vector<BrickContents>& contents) {
  WallFilm film(lines, contents);
  film.add_levels();
  for (const auto& wall : make_walls(parts)) film.add(wall);
  return film.faces();
}

}  // namespace

double edge_mm(MeshSize size) {
  constexpr std::array kEdges{4.6, 2.9, 2.1};
  return kEdges[static_cast<std::size_t>(size)];
}

GyroMesh make_mesh(const GyroModel& model, MeshSize size) { return make_mesh(model, edge_mm(size)); }

GyroMesh make_mesh(const GyroModel& model, double edge_mm) {
  const auto parts = make_parts(model);
  const auto lines = grid_lines(model, parts, edge_mm);
  auto contents = brick_contents(model, parts, lines);
  const bool full = model.mode == GyroMode::full;
  if (!full) merge_sparse_bricks(contents, lines);
  GyroMesh mesh;
  mesh.x = to_metres(lines.x);
  mesh.y = to_metres(lines.y);
  mesh.z = to_metres(lines.z);
  classify(contents, full, mesh);
  mesh.film = full ? shell_film(mesh) : block_film(parts, lines, contents);
  number_nodes(mesh);
  return mesh;
}

void number_nodes(GyroMesh& mesh) {
  const std::size_t points = static_cast<std::size_t>(2 * mesh.nx() + 1) * (2 * mesh.ny() + 1) * (2 * mesh.nz() + 1);
  mesh.nodes.assign(points, -1);
  mesh.element_count = 0;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass&) {
    if (mesh.bricks[mesh.brick(i, j, k)] == 0) return;
    ++mesh.element_count;
    for (const auto& position : kHex20Positions)
      mesh.nodes[mesh.point(2 * i + position[0], 2 * j + position[1], 2 * k + position[2])] = 0;
  });
  std::int32_t number = 0;
  for (auto& node : mesh.nodes)
    if (node == 0) node = number++;
  mesh.node_count = static_cast<std::size_t>(number);
}

double part_volume(const GyroMesh& mesh, GyroPart part) {
  double volume = 0;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass& brick) {
    volume += part_share(brick, part) * edges(mesh, i, j, k).volume();
  });
  return volume;
}

double part_share(const BrickClass& brick, GyroPart part) {
  const auto found = std::ranges::find(brick.shares, part, &PartShare::part);
  return found == brick.shares.end() ? 0 : found->share;
}

GyroPart main_part(const BrickClass& brick) { return std::ranges::max(brick.shares, {}, &PartShare::share).part; }

}  // namespace gyrotherm::thermal
