#include "thermal/block_film.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace gyrotherm {
namespace {

struct BrickPlace {
  int i, j, k;
};
constexpr std::array<BrickPlace, kBrickFaces> kBeside{
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

double filled(const BrickContents& brick) { return std::accumulate(brick.share.begin(), brick.share.end(), 0.0); }

/// The grid seen as places and lengths, in mm.
class Grid {
 public:
  explicit Grid(const GridLines& lines)
      : lines_(lines),
        nx_(static_cast<int>(lines.x.size()) - 1),
        ny_(static_cast<int>(lines.y.size()) - 1),
        nz_(static_cast<int>(lines.z.size()) - 1) {}
  [[nodiscard]] std::size_t bricks() const { return static_cast<std::size_t>(nx_) * ny_ * nz_; }
  [[nodiscard]] BrickPlace place(std::size_t brick) const {
    const auto b = static_cast<int>(brick);
    return {b % nx_, b / nx_ % ny_, b / nx_ / ny_};
  }
  [[nodiscard]] bool holds(BrickPlace p) const {
    return p.i >= 0 && p.j >= 0 && p.k >= 0 && p.i < nx_ && p.j < ny_ && p.k < nz_;
  }
  [[nodiscard]] std::size_t brick(BrickPlace p) const {
    return (static_cast<std::size_t>(p.k) * ny_ + p.j) * nx_ + p.i;
  }
  [[nodiscard]] PlanRectangle plan(BrickPlace p) const {
    return {lines_.x[p.i], lines_.x[p.i + 1], lines_.y[p.j], lines_.y[p.j + 1]};
  }
  [[nodiscard]] double height(BrickPlace p) const { return lines_.z[p.k + 1] - lines_.z[p.k]; }
  [[nodiscard]] double plan_area(BrickPlace p) const {
    const auto r = plan(p);
    return (r.x1 - r.x0) * (r.y1 - r.y0);
  }
  [[nodiscard]] double face_area(BrickPlace p, int face) const {
    const auto r = plan(p);
    return face < 2 ? (r.y1 - r.y0) * height(p) : face < 4 ? (r.x1 - r.x0) * height(p) : plan_area(p);
  }
  /// Which brick of the plan a point lies in.
  [[nodiscard]] BrickPlace at(PlanPoint point, int k) const {
    return {find(lines_.x, point.x), find(lines_.y, point.y), k};
  }
  [[nodiscard]] const GridLines& lines() const { return lines_; }
  [[nodiscard]] int layers() const { return nz_; }

 private:
  static int find(const std::vector<double>& lines, double value) {
    return static_cast<int>(std::ranges::upper_bound(lines, value) - lines.begin()) - 1;
  }
  const GridLines& lines_;
  int nx_, ny_, nz_;
};

/// An upright wall seen from outside on its right, walking from a to b.
struct Wall {
  PlanPoint a, b;
  double z0, z1;
};

PlanPoint between(PlanPoint a, PlanPoint b, double t) { return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}; }
double distance(PlanPoint a, PlanPoint b) { return std::hypot(b.x - a.x, b.y - a.y); }

/// A 45° face of the block, less what its mirror covers.
void add_slanted(const Wall& face, const Prism& mirror, std::vector<Wall>& walls) {
  const double half = distance(mirror.plan[3], mirror.plan[0]) / distance(face.a, face.b) / 2;
  const auto from = between(face.a, face.b, 0.5 - half);
  const auto to = between(face.a, face.b, 0.5 + half);
  walls.push_back({face.a, from, face.z0, face.z1});
  walls.push_back({from, to, face.z0, mirror.z0});
  walls.push_back({from, to, mirror.z1, face.z1});
  walls.push_back({to, face.b, face.z0, face.z1});
}

std::vector<Wall> walls_of(const GyroParts& parts) {
  std::vector<Wall> walls;
  const auto& plan = parts.block.plan;
  constexpr std::array<std::size_t, 4> kMirrorOfFace{1, 0, 2, 3};  // the 45° faces, counter-clockwise from +x +y
  for (std::size_t edge = 0; edge < plan.size(); ++edge) {
    const Wall wall{plan[edge], plan[(edge + 1) % plan.size()], parts.block.z0, parts.block.z1};
    if (edge % 2 == 1)
      add_slanted(wall, parts.mirrors[kMirrorOfFace[edge / 2]], walls);
    else
      walls.push_back(wall);
  }
  for (const auto& mirror : parts.mirrors)
    for (std::size_t edge = 0; edge < 3; ++edge)  // the fourth lies on the block
      walls.push_back({mirror.plan[edge], mirror.plan[edge + 1], mirror.z0, mirror.z1});
  for (const auto& box : parts.boxes) {
    if (is_gas(box.part)) continue;
    for (std::size_t edge = 0; edge < 4; ++edge)
      walls.push_back({box.plan[edge], box.plan[(edge + 1) % 4], box.z0, box.z1});
  }
  std::erase_if(walls, [](const Wall& w) { return distance(w.a, w.b) < 1e-9 || w.z1 - w.z0 < 1e-9; });
  return walls;
}

class FilmOfWalls {
 public:
  FilmOfWalls(const GridLines& lines, const std::vector<BrickContents>& contents)
      : grid_(lines), contents_(contents), area_(grid_.bricks() * kBrickFaces) {}

  void add_levels() {
    for (std::size_t b = 0; b < grid_.bricks(); ++b) {
      const auto p = grid_.place(b);
      for (const int face : {4, 5})
        if (exposed(p, face)) area_[b * kBrickFaces + face] = contents_[b].plan_share * grid_.plan_area(p);
    }
  }

  void add(const Wall& wall) {
    std::vector<double> cuts{0, 1};
    const auto cross = [&](const std::vector<double>& lines, double from, double to) {
      if (std::abs(to - from) < 1e-9) return;
      for (const double line : lines)
        if (const double t = (line - from) / (to - from); t > 0 && t < 1) cuts.push_back(t);
    };
    cross(grid_.lines().x, wall.a.x, wall.b.x);
    cross(grid_.lines().y, wall.a.y, wall.b.y);
    std::ranges::sort(cuts);
    const double length = distance(wall.a, wall.b);
    const PlanPoint out{(wall.b.y - wall.a.y) / length, (wall.a.x - wall.b.x) / length};
    for (std::size_t c = 1; c < cuts.size(); ++c) {
      const double piece = (cuts[c] - cuts[c - 1]) * length;
      if (piece < 1e-9) continue;
      const auto middle = between(wall.a, wall.b, (cuts[c] + cuts[c - 1]) / 2);
      for (int k = 0; k < grid_.layers(); ++k) {
        const double height = std::min(grid_.lines().z[k + 1], wall.z1) - std::max(grid_.lines().z[k], wall.z0);
        if (height > 1e-9) put(piece * height, middle, out, k);
      }
    }
  }

  [[nodiscard]] std::vector<FilmFace> faces() const {
    std::vector<FilmFace> found;
    for (std::size_t b = 0; b < grid_.bricks(); ++b)
      for (int face = 0; face < kBrickFaces; ++face)
        if (const double area = area_[b * kBrickFaces + face]; area > 0)
          found.push_back({b, face, area / grid_.face_area(grid_.place(b), face)});
    return found;
  }

 private:
  [[nodiscard]] bool kept(BrickPlace p) const { return grid_.holds(p) && filled(contents_[grid_.brick(p)]) > 0; }
  [[nodiscard]] static BrickPlace beside(BrickPlace p, int face) {
    return {p.i + kBeside[face].i, p.j + kBeside[face].j, p.k + kBeside[face].k};
  }
  [[nodiscard]] bool exposed(BrickPlace p, int face) const { return kept(p) && !kept(beside(p, face)); }

  /// A piece of wall with its middle and outward direction.
  void put(double area, PlanPoint middle, PlanPoint out, int k) {
    const auto brick = grid_.at({middle.x - 1e-6 * out.x, middle.y - 1e-6 * out.y}, k);
    int flat = -1;
    for (int face = 0; face < 4; ++face)
      if (out.x * kBeside[face].i + out.y * kBeside[face].j > 1 - 1e-9) flat = face;
    if (flat >= 0 && kept(brick)) {
      if (exposed(brick, flat)) area_[grid_.brick(brick) * kBrickFaces + flat] += area;  // else two parts touch there
      return;
    }
    for (int reach = 2; reach <= 8; reach *= 2)
      if (spread(area, middle, out, brick, reach)) return;
    assert(!"a wall far from every brick that stays");
  }

  bool spread(double area, PlanPoint middle, PlanPoint out, BrickPlace around, int reach) {
    struct Candidate {
      std::size_t face;
      double weight;
    };
    std::vector<Candidate> candidates;
    double sum = 0;
    for (int dj = -reach; dj <= reach; ++dj) {
      for (int di = -reach; di <= reach; ++di) {
        const BrickPlace p{around.i + di, around.j + dj, around.k};
        if (!kept(p)) continue;
        const auto r = grid_.plan(p);
        for (int face = 0; face < 4; ++face) {
          const double facing = out.x * kBeside[face].i + out.y * kBeside[face].j;
          if (facing < 0.1 || !exposed(p, face)) continue;
          const PlanPoint centre{(r.x0 + r.x1 + kBeside[face].i * (r.x1 - r.x0)) / 2,
                                 (r.y0 + r.y1 + kBeside[face].j * (r.y1 - r.y0)) / 2};
          const double d = distance(centre, middle);
          const double scale = (r.x1 - r.x0) * (r.x1 - r.x0) + (r.y1 - r.y0) * (r.y1 - r.y0);
          const double weight = facing * grid_.face_area(p, face) * std::exp(-2 * d * d / scale);
          candidates.push_back({grid_.brick(p) * kBrickFaces + face, weight});
          sum += weight;
        }
      }
    }
    if (sum < 1e-12) return false;
    for (const auto& [face, weight] : candidates) area_[face] += area * weight / sum;
    return true;
  }

  Grid grid_;
  const std::vector<BrickContents>& contents_;
  std::vector<double> area_;  // mm², by brick and face
};

}  // namespace

void consolidate(std::vector<BrickContents>& contents, const GridLines& lines) {
  const Grid grid(lines);
  const auto before = contents;
  const auto stays = [&](const BrickContents& brick) { return brick.whole || brick.plan_share >= 0.5; };
  for (std::size_t b = 0; b < contents.size(); ++b) {
    if (stays(before[b]) || filled(before[b]) == 0) continue;
    const auto here = grid.place(b);
    std::size_t best = b;
    double fullest = 0.5 - 1e-9;
    for (int face = 0; face < 4; ++face) {
      const BrickPlace p{here.i + kBeside[face].i, here.j + kBeside[face].j, here.k};
      if (!grid.holds(p)) continue;
      const auto& neighbour = before[grid.brick(p)];
      double glass = 0;
      for (std::size_t part = 0; is_glass(static_cast<GyroPart>(part)); ++part) glass += neighbour.share[part];
      if (!stays(neighbour) || glass == 0 || neighbour.plan_share < fullest + 1e-9) continue;
      fullest = neighbour.plan_share;
      best = grid.brick(p);
    }
    if (best == b) continue;
    const double ratio = grid.plan_area(here) / grid.plan_area(grid.place(best));
    for (std::size_t part = 0; part < kGyroParts; ++part) contents[best].share[part] += ratio * before[b].share[part];
    contents[best].plan_share += ratio * before[b].plan_share;
    contents[b] = {};
  }
}

std::vector<FilmFace> block_film(const GyroParts& parts, const GridLines& lines,
                                 const std::vector<BrickContents>& contents) {
  FilmOfWalls film(lines, contents);
  film.add_levels();
  for (const auto& wall : walls_of(parts)) film.add(wall);
  return film.faces();
}

}  // namespace gyrotherm
