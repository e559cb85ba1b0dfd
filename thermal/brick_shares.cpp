#include "thermal/brick_shares.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm {
namespace {

constexpr double kSame = 1e-6;  // mm

std::vector<double> divided(std::vector<double> marks, double edge_mm) {
  std::ranges::sort(marks);
  std::vector<double> lines{marks.front()};
  for (const double mark : marks) {
    const double from = lines.back();
    if (mark - from < kSame) continue;
    const auto pieces = std::max(1L, std::lround((mark - from) / edge_mm));
    for (long piece = 1; piece < pieces; ++piece) {
      lines.push_back(from + (mark - from) * static_cast<double>(piece) / static_cast<double>(pieces));
    }
    lines.push_back(mark);
  }
  return lines;
}

/// How much of [a0, a1] lies in [b0, b1], of 1.
double overlap(double a0, double a1, double b0, double b1) {
  return std::max(0.0, std::min(a1, b1) - std::max(a0, b0)) / (a1 - a0);
}

/// What a shape covers of a rectangle, of 1, and the integral of its outward normal over its edge inside, mm.
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

/// The outward normals of a closed outline add up to zero: those inside are less those on the rectangle's sides.
Cover covered(const PlanRectangle& r, const Prism& prism) {
  const auto box = bounds(prism.plan);
  if (box.x1 <= r.x0 || box.x0 >= r.x1 || box.y1 <= r.y0 || box.y0 >= r.y1) return {};
  const auto shared = intersection(prism.plan, outline_of(r));
  Cover cover{area(shared) / ((r.x1 - r.x0) * (r.y1 - r.y0)), {}};
  for (std::size_t i = 0; i < shared.size(); ++i) {
    const auto a = shared[i];
    const auto b = shared[(i + 1) % shared.size()];
    const auto on = [&](double from, double to, double side) {
      return std::abs(from - side) < kSame && std::abs(to - side) < kSame;
    };
    if (on(a.x, b.x, r.x0) || on(a.x, b.x, r.x1)) cover.outward.x -= b.y - a.y;
    if (on(a.y, b.y, r.y0) || on(a.y, b.y, r.y1)) cover.outward.y += b.x - a.x;
  }
  return cover;
}

/// What of a brick's plan the upright parts cover, whatever the height.
struct Column {
  Cover block;  ///< without the hole
  std::array<Cover, 4> mirrors;
  Cover dither;  ///< without the hub
  Cover hub;
  double area_mm2{};
  bool inside{};  ///< of the cabinet's walls
};

Column column_of(const GyroParts& parts, const PlanRectangle& r) {
  Column column;
  column.area_mm2 = (r.x1 - r.x0) * (r.y1 - r.y0);
  const auto hole = covered(r, parts.hole);
  column.hub = covered(r, parts.hub);
  column.dither = hole - column.hub;
  column.block = covered(r, parts.block) - hole;
  for (std::size_t m = 0; m < 4; ++m) column.mirrors[m] = covered(r, parts.mirrors[m]);
  const double x = (r.x0 + r.x1) / 2;
  const double y = (r.y0 + r.y1) / 2;
  column.inside = x > parts.inside.x0 && x < parts.inside.x1 && y > parts.inside.y0 && y < parts.inside.y1;
  return column;
}

BrickContents whole(GyroPart part) {
  BrickContents contents;
  contents.share[index(part)] = 1;
  contents.plan_share = 1;
  return contents;
}

/// The direction across the face that cuts a brick: that of the glass, or else that of the hub, or else that of the
/// dither.
std::array<double, 3> across(const GyroParts& parts, const Column& column, double z0, double z1) {
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

/// What the upright parts leave is air in full mode and nothing in block mode.
BrickContents mixed(const GyroModel& model, const GyroParts& parts, const Column& column, double z0, double z1) {
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
  if (full) {
    contents.share[index(air_at(model, (z0 + z1) / 2))] += std::max(0.0, 1 - filled);
    if (!contents.whole) contents.across = across(parts, column, z0, z1);
  }
  return contents;
}

}  // namespace

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
  return {divided(x, edge_mm), divided(y, edge_mm), divided(z, edge_mm)};
}

std::vector<BrickContents> brick_contents(const GyroModel& model, const GyroParts& parts, const GridLines& lines) {
  const auto nx = lines.x.size() - 1;
  const auto ny = lines.y.size() - 1;
  const auto nz = lines.z.size() - 1;
  std::vector<BrickContents> all(nx * ny * nz);
  for (std::size_t j = 0; j < ny; ++j) {
    for (std::size_t i = 0; i < nx; ++i) {
      const PlanRectangle r{lines.x[i], lines.x[i + 1], lines.y[j], lines.y[j + 1]};
      const PlanPoint middle{(r.x0 + r.x1) / 2, (r.y0 + r.y1) / 2};
      const auto column = column_of(parts, r);
      std::vector<const Prism*> here;
      for (const auto& box : parts.boxes)
        if (contains(box.plan, middle)) here.push_back(&box);
      for (std::size_t k = 0; k < nz; ++k) {
        const double z = (lines.z[k] + lines.z[k + 1]) / 2;
        auto& contents = all[(k * ny + j) * nx + i];
        const auto box = std::ranges::find_if(here, [&](const Prism* prism) { return z > prism->z0 && z < prism->z1; });
        if (box != here.end())
          contents = whole((*box)->part);
        else if (model.mode == GyroMode::full && (!column.inside || z < parts.inside_z0 || z > parts.inside_z1))
          contents = whole(GyroPart::shell);
        else
          contents = mixed(model, parts, column, lines.z[k], lines.z[k + 1]);
      }
    }
  }
  return all;
}

}  // namespace gyrotherm
