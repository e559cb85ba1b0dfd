// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/brick_operator.hpp"

#include <algorithm>
#include <cassert>

#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/hex20.hpp"

// The product is compiled once per generation of x86-64, like the hot loops of analysis/svm. Its results agree between
// processors to rounding, and exactly on one processor.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define GYROTHERM_BRICK_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define GYROTHERM_BRICK_CLONES
#endif
#define GYROTHERM_BRICK_INLINE __attribute__((always_inline)) inline

namespace gyrotherm::thermal {
namespace {

constexpr int kLineBytes = 64;
template <class Real>
constexpr int kLanes = kLineBytes / static_cast<int>(sizeof(Real));

/// Maps a number type to its SIMD vector.
template <class Real>
struct LineOf;
template <>
struct LineOf<float> {
  using Line = float __attribute__((vector_size(kLineBytes)));
};
template <>
struct LineOf<double> {
  using Line = double __attribute__((vector_size(kLineBytes)));
};

/// Load, store and add vectors at unaligned addresses. A cast to a type of lesser alignment would not help: template
/// arguments lose the alignment attribute.
template <class Line, class Real>
GYROTHERM_BRICK_INLINE void load(const Real* from, Line& line) {
  __builtin_memcpy(&line, from, sizeof line);
}
template <class Line, class Real>
GYROTHERM_BRICK_INLINE void store(Real* to, const Line& line) {
  __builtin_memcpy(to, &line, sizeof line);
}
template <class Line, class Real>
GYROTHERM_BRICK_INLINE void add(Real* to, const Line& line) {
  Line sum;
  load(to, sum);
  sum += line;
  store(to, sum);
}

/// Converts values at (−, −), (+, −), (−, +), (+, +) to their sums with the signs of 1, a, b, ab. spread() is the
/// transpose.
template <class Line>
GYROTHERM_BRICK_INLINE void sums(const Line* at, Line* of) {
  const Line low = at[0] + at[1], high = at[2] + at[3], low_slope = at[1] - at[0], high_slope = at[3] - at[2];
  of[0] = low + high;
  of[1] = low_slope + high_slope;
  of[2] = high - low;
  of[3] = high_slope - low_slope;
}
template <class Line>
GYROTHERM_BRICK_INLINE void spread(const Line* of, Line* at) {
  const Line low = of[0] - of[2], high = of[0] + of[2], low_slope = of[1] - of[3], high_slope = of[1] + of[3];
  at[0] = low - low_slope;
  at[1] = low + low_slope;
  at[2] = high - high_slope;
  at[3] = high + high_slope;
}

/// Weights of adjacent bricks, W/K.
template <class Line>
struct BrickConductances {
  Line x, y, z;
};

/// Coefficients of adjacent bricks, or the forces on them. `x[q]`, `y[q]`, `z[q]`: P₂ along that axis times odd factors
/// in the other two axes, given by the bits of q in the order of the axes. `odd[p]`: only the odd factors given by the
/// bits of p, without P₂. The functions below write t for the coefficients with P₂, w for the coefficients without P₂,
/// and g for the forces on either.
template <class Line>
struct Polynomials {
  Line x[4], y[4], z[4], odd[8];
};

/// Sums over the nodes of adjacent bricks; after convert_to_forces() the forces on the nodes. `corner[p]`, p = bit 0
/// for x, bit 1 for y, bit 2 for z: sums over the corners, odd in the axes of the bits. `on_x`, `on_y`, `on_z`: sums
/// over the midpoints of the edges along an axis, with bits for the other two axes in order.
template <class Line>
struct NodeSums {
  Line corner[8], on_x[4], on_y[4], on_z[4];
};

template <class Real>
constexpr Real kEdge = Real(1) / 144;
template <class Real>
constexpr Real kCorner = Real(1) / 576;

/// Computes 12 times the coefficients with P₂, and 24 times the coefficients without P₂. For a corner sum c and an edge
/// sum e of the same parity these are t = c − 2e and w = 3c − 2Σt.
template <class Line>
GYROTHERM_BRICK_INLINE void find_coefficients(const NodeSums<Line>& sums, Polynomials<Line>& found) {
  const auto& [corner, on_x, on_y, on_z] = sums;
  auto& [tx, ty, tz, w] = found;
  for (int q = 0; q < 4; ++q) {
    tx[q] = corner[2 * q] - 2 * on_x[q];
    ty[q] = corner[(q & 1) + 4 * (q >> 1)] - 2 * on_y[q];
    tz[q] = corner[q] - 2 * on_z[q];
  }
  w[0] = Line{};
  w[1] = 3 * corner[1] - 2 * (ty[1] + tz[1]);
  w[2] = 3 * corner[2] - 2 * (tx[1] + tz[2]);
  w[3] = 3 * corner[3] - 2 * tz[3];
  w[4] = 3 * corner[4] - 2 * (tx[2] + ty[2]);
  w[5] = 3 * corner[5] - 2 * ty[3];
  w[6] = 3 * corner[6] - 2 * tx[3];
  w[7] = 3 * corner[7];
}

/// Computes the forces on the coefficients by k_xx, k_yy and k_zz, without the part of w that is contained in t. The
/// energy is diagonal in these polynomials: ∫P₂'² = 6, ∫P₂² = 2/5, ∫1 = 2, ∫x² = 2/3.
template <class Real, class Line>
GYROTHERM_BRICK_INLINE void find_forces(const BrickConductances<Line>& k, const Polynomials<Line>& at,
                                        Polynomials<Line>& force) {
  constexpr Real kA = 24 * kEdge<Real>, kB = 8 * kEdge<Real>, kC = kEdge<Real> * 8 / 3, kD = kEdge<Real> * 8 / 5,
                 kE = kEdge<Real> * 8 / 15;
  const auto edges_along = [&](const Line& along, const Line& first, const Line& second, const Line* t, Line* g)
      __attribute__((always_inline)) {
    g[0] = kA * along * t[0];
    g[1] = (kB * along + kD * first) * t[1];
    g[2] = (kB * along + kD * second) * t[2];
    g[3] = (kC * along + kE * (first + second)) * t[3];
  };
  edges_along(k.x, k.y, k.z, at.x, force.x);
  edges_along(k.y, k.x, k.z, at.y, force.y);
  edges_along(k.z, k.x, k.y, at.z, force.z);
  constexpr Real kOne = 8 * kCorner<Real>, kTwo = kCorner<Real> * 8 / 3, kThree = kCorner<Real> * 8 / 9;
  const Line* w = at.odd;
  Line* g = force.odd;
  g[1] = kOne * k.x * w[1];
  g[2] = kOne * k.y * w[2];
  g[3] = kTwo * (k.x + k.y) * w[3];
  g[4] = kOne * k.z * w[4];
  g[5] = kTwo * (k.x + k.z) * w[5];
  g[6] = kTwo * (k.y + k.z) * w[6];
  g[7] = kThree * (k.x + k.y + k.z) * w[7];
}

/// Adds the forces by k_xy. ∫(∂x u ∂y v + ∂y u ∂x v) couples few of the polynomials: 4 n, n = 2, or 2/3 if both are odd
/// in z.
template <class Real, class Line>
GYROTHERM_BRICK_INLINE void add_slanted_forces(const Line& xy, const Polynomials<Line>& at, Polynomials<Line>& force) {
  constexpr Real kMixed = Real(1) / 288;
  const auto& [tx, ty, tz, w] = at;
  auto& [gx, gy, gz, g] = force;
  for (int b = 0; b < 2; ++b) {
    const Real n = b == 0 ? 8 : Real(8) / 3;
    const int up = 4 * b;
    gx[2 * b] += n * kMixed * xy * w[3 + up];  // P₂(x) with xy
    g[3 + up] += n * kMixed * xy * tx[2 * b];
    gy[2 * b] += n * kMixed * xy * w[3 + up];  // P₂(y) with xy
    g[3 + up] += n * kMixed * xy * ty[2 * b];
    gx[1 + 2 * b] += n * kEdge<Real> * xy * ty[1 + 2 * b];  // P₂(x) y with x P₂(y)
    gy[1 + 2 * b] += n * kEdge<Real> * xy * tx[1 + 2 * b];
    g[1 + up] += n * kCorner<Real> * xy * w[2 + up];  // x with y
    g[2 + up] += n * kCorner<Real> * xy * w[1 + up];
  }
  gz[1] += kEdge<Real> * 8 / 5 * xy * tz[2];  // x P₂(z) with y P₂(z)
  gz[2] += kEdge<Real> * 8 / 5 * xy * tz[1];
}

/// Converts the forces on the coefficients to forces on the nodes' sums. Adds to `force` the part of w that is
/// contained in t.
template <class Line>
GYROTHERM_BRICK_INLINE void write_forces(Polynomials<Line>& force, NodeSums<Line>& to) {
  auto& [gx, gy, gz, g] = force;
  auto& [corner, on_x, on_y, on_z] = to;
  gx[1] -= 2 * g[2];
  gx[2] -= 2 * g[4];
  gx[3] -= 2 * g[6];
  gy[1] -= 2 * g[1];
  gy[2] -= 2 * g[4];
  gy[3] -= 2 * g[5];
  gz[1] -= 2 * g[1];
  gz[2] -= 2 * g[2];
  gz[3] -= 2 * g[3];
  corner[0] = gx[0] + gy[0] + gz[0];
  corner[1] = 3 * g[1] + gy[1] + gz[1];
  corner[2] = 3 * g[2] + gx[1] + gz[2];
  corner[3] = 3 * g[3] + gz[3];
  corner[4] = 3 * g[4] + gx[2] + gy[2];
  corner[5] = 3 * g[5] + gy[3];
  corner[6] = 3 * g[6] + gx[3];
  corner[7] = 3 * g[7];
  for (int q = 0; q < 4; ++q) {
    on_x[q] = -2 * gx[q];
    on_y[q] = -2 * gy[q];
    on_z[q] = -2 * gz[q];
  }
}

/// Replaces sums over nodes by the forces on the nodes.
template <class Real, bool slanted, class Line>
GYROTHERM_BRICK_INLINE void convert_to_forces(const BrickConductances<Line>& k, const Line& xy, NodeSums<Line>& sums) {
  Polynomials<Line> coefficients, force;
  find_coefficients(sums, coefficients);
  find_forces<Real>(k, coefficients, force);
  if constexpr (slanted) add_slanted_forces<Real>(xy, coefficients, force);
  write_forces(force, sums);
}

/// The rows of positions around a row of bricks along x: corners and midpoints of x-edges at (j, k), (j + 1, k), (j, k
/// + 1), (j + 1, k + 1); midpoints of y-edges below and above, of z-edges at j and j + 1.
template <class Pointer>
struct RowsAround {
  Pointer corner[4], x_edge[4], y_edge[2], z_edge[2];

  RowsAround(const FieldLayout& layout, int j, int k, Pointer field) {
    for (int n = 0; n < 4; ++n) {
      corner[n] = field + layout.corner(0, j + n % 2, k + n / 2);
      x_edge[n] = field + layout.x_edge(0, j + n % 2, k + n / 2);
    }
    for (int n = 0; n < 2; ++n) {
      y_edge[n] = field + layout.y_edge(0, j, k + n);
      z_edge[n] = field + layout.z_edge(0, j + n, k);
    }
  }
};

/// Contributions of a row of bricks at the left and at the right end of each brick: 4 corners, 2 y-edges and 2 z-edges.
template <class Real>
struct RowEnds {
  std::vector<Real> values;
  std::size_t length;
  explicit RowEnds(int bricks)
      : values(16 * static_cast<std::size_t>(bricks + 2 * kLanes<Real>)), length(values.size() / 16) {}
  [[nodiscard]] Real* left(int n) { return values.data() + 2 * static_cast<std::size_t>(n) * length; }
  /// Returns values shifted by one; the right end of a brick then aligns with the left end of the next.
  [[nodiscard]] Real* right(int n) { return left(n) + length + 1; }
};

/// Gathers the node sums of consecutive bricks of a row, from brick i on, one brick per element of a vector.
template <class Real, class Line>
GYROTHERM_BRICK_INLINE void gather(const RowsAround<const Real*>& from, int i, NodeSums<Line>& nodes) {
  auto& [corner, on_x, on_y, on_z] = nodes;
  Line even[4], odd[4], of[4];
  for (int n = 0; n < 4; ++n) {
    Line left, right;
    load(from.corner[n] + i, left);
    load(from.corner[n] + i + 1, right);
    even[n] = left + right;
    odd[n] = right - left;
  }
  sums(even, of);
  for (int q = 0; q < 4; ++q) corner[2 * q] = of[q];
  sums(odd, of);
  for (int q = 0; q < 4; ++q) corner[2 * q + 1] = of[q];
  for (int n = 0; n < 4; ++n) load(from.x_edge[n] + i, of[n]);
  sums(of, on_x);
  for (int n = 0; n < 4; ++n) load(from.y_edge[n / 2] + i + n % 2, of[n]);
  sums(of, on_y);
  for (int n = 0; n < 4; ++n) load(from.z_edge[n / 2] + i + n % 2, of[n]);
  sums(of, on_z);
}

/// Scatters the forces on the nodes of the same bricks. Adds forces on x-edges to the product and stores forces at the
/// bricks' left and right ends, where neighbours in the row meet.
template <class Real, class Line>
GYROTHERM_BRICK_INLINE void scatter(const NodeSums<Line>& nodes, int i, const RowsAround<Real*>& to,
                                    RowEnds<Real>& ends) {
  const auto& [corner, on_x, on_y, on_z] = nodes;
  Line even[4], odd[4], of[4];
  spread(on_x, of);
  for (int n = 0; n < 4; ++n) add(to.x_edge[n] + i, of[n]);
  for (int q = 0; q < 4; ++q) of[q] = corner[2 * q];
  spread(of, even);
  for (int q = 0; q < 4; ++q) of[q] = corner[2 * q + 1];
  spread(of, odd);
  for (int n = 0; n < 4; ++n) {
    const Line left = even[n] - odd[n], right = even[n] + odd[n];
    store(ends.left(n) + i, left);
    store(ends.right(n) + i, right);
  }
  spread(on_y, of);
  for (int n = 0; n < 4; ++n) store((n % 2 == 0 ? ends.left(4 + n / 2) : ends.right(4 + n / 2)) + i, of[n]);
  spread(on_z, of);
  for (int n = 0; n < 4; ++n) store((n % 2 == 0 ? ends.left(6 + n / 2) : ends.right(6 + n / 2)) + i, of[n]);
}

/// Multiplies consecutive bricks of a row, from brick i on, one brick per element of a vector.
template <class Real, bool slanted>
GYROTHERM_BRICK_INLINE void multiply_line(const BrickWeights<Real>& weights, std::size_t row, int i,
                                          const RowsAround<const Real*>& from, const RowsAround<Real*>& to,
                                          RowEnds<Real>& ends) {
  using Line = typename LineOf<Real>::Line;
  const auto at = row + static_cast<std::size_t>(i);
  BrickConductances<Line> k;
  load(weights.x.data() + at, k.x);
  load(weights.y.data() + at, k.y);
  load(weights.z.data() + at, k.z);
  Line xy{};
  if constexpr (slanted) load(weights.xy.data() + at, xy);
  NodeSums<Line> nodes;
  gather(from, i, nodes);
  convert_to_forces<Real, slanted>(k, xy, nodes);
  scatter(nodes, i, to, ends);
}

/// Adds the stored contributions of neighbouring bricks, which share the ends of a row, to the row's product.
template <class Real>
GYROTHERM_BRICK_INLINE void add_ends(RowEnds<Real>& ends, int bricks, const RowsAround<Real*>& to) {
  for (int n = 0; n < 8; ++n) {
    Real* const there = n < 4 ? to.corner[n] : n < 6 ? to.y_edge[n - 4] : to.z_edge[n - 6];
    const Real* const left = ends.left(n);
    const Real* const right = ends.right(n) - 1;
    for (int i = 0; i <= bricks; i += kLanes<Real>) {
      typename LineOf<Real>::Line one, other;
      load(left + i, one);
      load(right + i, other);
      one += other;
      add(there + i, one);
    }
  }
}

template <class Real>
GYROTHERM_BRICK_INLINE void multiply_rows(const FieldLayout& layout, const BrickWeights<Real>& weights,
                                          const Real* field, Real* product) {
  std::fill_n(product, layout.padded_size(), Real(0));
  RowEnds<Real> ends(layout.nx());
  for (int k = 0; k < layout.nz(); ++k) {
    for (int j = 0; j < layout.ny(); ++j) {
      const RowsAround<const Real*> from(layout, j, k, field);
      const RowsAround<Real*> to(layout, j, k, product);
      const auto row = weights.row(j, k, layout.ny());
      const bool slanted = weights.slanted[row / static_cast<std::size_t>(weights.stride)];
      for (int i = 0; i < weights.stride; i += kLanes<Real>) {
        if (slanted)
          multiply_line<Real, true>(weights, row, i, from, to, ends);
        else
          multiply_line<Real, false>(weights, row, i, from, to, ends);
      }
      add_ends(ends, layout.nx(), to);
    }
  }
}

GYROTHERM_BRICK_CLONES void multiply_bricks(const FieldLayout& layout, const BrickWeights<double>& weights,
                                            const double* field, double* product) {
  multiply_rows(layout, weights, field, product);
}
GYROTHERM_BRICK_CLONES void multiply_bricks(const FieldLayout& layout, const BrickWeights<float>& weights,
                                            const float* field, float* product) {
  multiply_rows(layout, weights, field, product);
}

/// Heat flow through a film of 1 W/K, by face and two of its nodes.
template <class Real>
using FaceMatrices = std::array<std::array<std::array<Real, 8>, 8>, kBrickFaces>;

template <class Real>
FaceMatrices<Real> face_matrices() {
  FaceMatrices<Real> all{};
  for (int face = 0; face < kBrickFaces; ++face) {
    const auto nodes = face_nodes(face);
    const auto& mass = hex20_integrals().face_mass[face];
    for (std::size_t n = 0; n < 8; ++n)
      for (std::size_t m = 0; m < 8; ++m) all[face][n][m] = static_cast<Real>(mass(nodes[n], nodes[m]));
  }
  return all;
}

template <class Real>
void multiply_film(const BrickWeights<Real>& weights, const Real* field, Real* product) {
  static const auto matrices = face_matrices<Real>();
  for (const auto& face : weights.film) {
    std::array<Real, 8> sum{};
    for (std::size_t m = 0; m < 8; ++m) {
      const Real value = face.film * field[face.positions[m]];
      for (std::size_t n = 0; n < 8; ++n) sum[n] += matrices[face.face][m][n] * value;
    }
    for (std::size_t n = 0; n < 8; ++n) product[face.positions[n]] += sum[n];
  }
}

}  // namespace

FieldLayout::FieldLayout(const GyroMesh& mesh) : nx_(mesh.nx()), ny_(mesh.ny()), nz_(mesh.nz()) {
  const auto count = [](int a, int b, int c) { return static_cast<Eigen::Index>(a) * b * c; };
  x_edges_ = count(nx_ + 1, ny_ + 1, nz_ + 1);
  y_edges_ = x_edges_ + count(nx_, ny_ + 1, nz_ + 1);
  z_edges_ = y_edges_ + count(nx_ + 1, ny_, nz_ + 1);
  count_ = z_edges_ + count(nx_ + 1, ny_ + 1, nz_);
  node_positions_.resize(mesh.node_count);
  each_node(mesh, [&](int node, int I, int J, int K) {
    node_positions_[static_cast<std::size_t>(node)] = static_cast<std::int32_t>(point_position(I, J, K));
  });
}

Eigen::Index FieldLayout::point_position(int I, int J, int K) const {
  const int i = I / 2, j = J / 2, k = K / 2;
  if (I % 2 != 0) return x_edge(i, j, k);
  if (J % 2 != 0) return y_edge(i, j, k);
  return K % 2 != 0 ? z_edge(i, j, k) : corner(i, j, k);
}

Eigen::Index FieldLayout::node_position(int i, int j, int k, int node) const {
  const auto& at = kHex20Positions[node];
  return point_position(2 * i + at[0], 2 * j + at[1], 2 * k + at[2]);
}

Eigen::VectorXd FieldLayout::from_nodes(const Eigen::VectorXd& field) const {
  assert(field.size() == static_cast<Eigen::Index>(node_positions_.size()));
  Eigen::VectorXd placed = Eigen::VectorXd::Zero(padded_size());
  for (std::size_t node = 0; node < node_positions_.size(); ++node)
    placed[node_positions_[node]] = field[static_cast<Eigen::Index>(node)];
  return placed;
}

Eigen::VectorXd FieldLayout::to_nodes(const Eigen::VectorXd& field) const {
  Eigen::VectorXd by_node(static_cast<Eigen::Index>(node_positions_.size()));
  for (std::size_t node = 0; node < node_positions_.size(); ++node)
    by_node[static_cast<Eigen::Index>(node)] = field[node_positions_[node]];
  return by_node;
}

std::array<int, 8> face_nodes(int face) {
  std::array<int, 8> nodes{};
  std::size_t found = 0;
  for (int n = 0; n < kHex20; ++n)
    if (kHex20Positions[n][face / 2] == (face % 2 == 0 ? 0 : 2)) nodes[found++] = n;
  assert(found == nodes.size());
  return nodes;
}

template <class Real>
BrickWeights<Real>::BrickWeights(const GyroModel& model, const GyroMesh& mesh, const FieldLayout& layout,
                                 const ThermalCoefficients& coefficients)
    : stride((mesh.nx() + kLanes<float> - 1) / kLanes<float> * kLanes<float>) {
  const auto rows = static_cast<std::size_t>(mesh.ny()) * static_cast<std::size_t>(mesh.nz());
  for (auto* weight : {&x, &y, &z, &xy}) weight->assign(rows * static_cast<std::size_t>(stride), Real(0));
  slanted.assign(rows, false);
  std::vector<Conductivity> of_class;
  for (const auto& brick : mesh.classes) of_class.push_back(conductivity(model, brick, coefficients));
  each_weighted_brick(layout, *this, [&](int i, int j, int k, std::size_t at) {
    const auto& conducts = of_class[mesh.bricks[mesh.brick(i, j, k)]];
    const auto h = edges(mesh, i, j, k);
    const double half = h.volume() / 2;
    x[at] = static_cast<Real>(half * conducts.xx / (h.x * h.x));
    y[at] = static_cast<Real>(half * conducts.yy / (h.y * h.y));
    z[at] = static_cast<Real>(half * conducts.zz / (h.z * h.z));
    xy[at] = static_cast<Real>(half * conducts.xy / (h.x * h.y));
    if (conducts.xy != 0) slanted[at / static_cast<std::size_t>(stride)] = true;
  });
  const double film_w_per_m2_k = coefficients[static_cast<std::size_t>(ThermalCoefficient::film)];
  for (const auto& face : mesh.film) {
    const auto [i, j, k] = mesh.brick_position(face.brick);
    const double scale = film_w_per_m2_k * face.factor * edges(mesh, i, j, k).face_area(face.face) / 4;
    Face made{{}, face.face, static_cast<Real>(scale)};
    const auto nodes = face_nodes(face.face);
    for (std::size_t n = 0; n < 8; ++n)
      made.positions[n] = static_cast<std::int32_t>(layout.node_position(i, j, k, nodes[n]));
    film.push_back(made);
  }
}

template <class Real>
void multiply(const FieldLayout& layout, const BrickWeights<Real>& weights, const Real* field, Real* product) {
  multiply_bricks(layout, weights, field, product);
  multiply_film(weights, field, product);
}

template <class Real>
Eigen::Matrix<Real, Eigen::Dynamic, 1> diagonal(const FieldLayout& layout, const BrickWeights<Real>& weights) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(layout.padded_size());
  const auto& r = hex20_integrals();
  each_weighted_brick(layout, weights, [&](int i, int j, int k, std::size_t at) {
    for (int n = 0; n < kHex20; ++n)
      sum[layout.node_position(i, j, k, n)] += weights.x[at] * r.slopes[0](n, n) + weights.y[at] * r.slopes[1](n, n) +
                                               weights.z[at] * r.slopes[2](n, n) + weights.xy[at] * r.cross(n, n);
  });
  for (const auto& face : weights.film) {
    const auto nodes = face_nodes(face.face);
    for (std::size_t n = 0; n < 8; ++n)
      sum[face.positions[n]] += face.film * r.face_mass[face.face](nodes[n], nodes[n]);
  }
  return sum.cast<Real>();
}

template struct BrickWeights<float>;
template struct BrickWeights<double>;
template void multiply(const FieldLayout&, const BrickWeights<float>&, const float*, float*);
template void multiply(const FieldLayout&, const BrickWeights<double>&, const double*, double*);
template Eigen::VectorXf diagonal(const FieldLayout&, const BrickWeights<float>&);
template Eigen::VectorXd diagonal(const FieldLayout&, const BrickWeights<double>&);

}  // namespace gyrotherm::thermal
