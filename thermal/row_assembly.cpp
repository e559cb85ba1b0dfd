#include "thermal/row_assembly.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cassert>

#include "thermal/assembly.hpp"
#include "thermal/hex20.hpp"

namespace gyrotherm {
namespace {

constexpr int kReach = 125;  // points of the doubled grid at most two away along each axis
using Reached = std::bitset<kReach>;

/// For every two nodes of a brick, which of the 125 points around the first the second is; in order of node numbers.
struct Around {
  std::array<std::array<int, kHex20>, kHex20> of{};
  std::array<Reached, kHex20> reached{};
  std::array<int, 27> node_at{};  ///< node of the brick at a place, −1: none
};

Around make_around() {
  Around around;
  around.node_at.fill(-1);
  for (int n = 0; n < kHex20; ++n) {
    const auto& from = kHex20Places[n];
    around.node_at[from[0] + 3 * from[1] + 9 * from[2]] = n;
    for (int m = 0; m < kHex20; ++m) {
      const auto& to = kHex20Places[m];
      around.of[n][m] = (to[0] - from[0] + 2) + 5 * (to[1] - from[1] + 2) + 25 * (to[2] - from[2] + 2);
      around.reached[n].set(around.of[n][m]);
    }
  }
  return around;
}

/// First and last of the bricks that a point of the doubled grid touches along one axis.
struct Span {
  int from, to;
};
Span span(int place, int bricks) {
  const int last = place / 2;
  return {std::max(0, place % 2 == 0 ? last - 1 : last), std::min(bricks - 1, last)};
}

class Rows {
 public:
  Rows(const GyroMesh& mesh, const std::vector<BrickWeight>& weight_of_class)
      : mesh_(mesh), weights_(weight_of_class), around_(make_around()), reference_(hex20_integrals()) {}

  SparseMatrix assemble() {
    const auto n = static_cast<Eigen::Index>(mesh_.node_count);
    SparseMatrix matrix(n, n);
    auto* outer = matrix.outerIndexPtr();
    outer[0] = 0;
    each_node([&](int node, int I, int J, int K) {
      Reached reached;
      each_brick(I, J, K, [&](int, int, int, int local, const BrickWeight&) { reached |= around_.reached[local]; });
      outer[node + 1] = static_cast<int>(reached.count());
    });
    std::int64_t total = 0;
    for (Eigen::Index row = 0; row < n; ++row) {
      total += outer[row + 1];
      assert(total < std::int64_t{1} << 31);
      outer[row + 1] = static_cast<int>(total);
    }
    matrix.resizeNonZeros(total);
    each_node([&](int node, int I, int J, int K) { fill(matrix, node, I, J, K); });
    return matrix;
  }

 private:
  template <class Visit>
  void each_node(Visit visit) const {
    std::size_t point = 0;
    for (int K = 0; K <= 2 * mesh_.nz(); ++K)
      for (int J = 0; J <= 2 * mesh_.ny(); ++J)
        for (int I = 0; I <= 2 * mesh_.nx(); ++I, ++point)
          if (mesh_.nodes[point] >= 0) visit(mesh_.nodes[point], I, J, K);
  }

  /// Bricks of weight around a point, with the point's number in each.
  template <class Visit>
  void each_brick(int I, int J, int K, Visit visit) const {
    const auto xs = span(I, mesh_.nx());
    const auto ys = span(J, mesh_.ny());
    const auto zs = span(K, mesh_.nz());
    for (int k = zs.from; k <= zs.to; ++k)
      for (int j = ys.from; j <= ys.to; ++j)
        for (int i = xs.from; i <= xs.to; ++i) {
          const auto& weight = weights_[mesh_.bricks[mesh_.brick(i, j, k)]];
          if (weight.zz == 0 && weight.xx == 0 && weight.capacity == 0) continue;
          visit(i, j, k, around_.node_at[(I - 2 * i) + 3 * (J - 2 * j) + 9 * (K - 2 * k)], weight);
        }
  }

  void fill(SparseMatrix& matrix, int node, int I, int J, int K) {
    std::array<double, kReach> sum{};
    Reached reached;
    each_brick(I, J, K, [&](int i, int j, int k, int local, const BrickWeight& weight) {
      reached |= around_.reached[local];
      const auto h = edges(mesh_, i, j, k);
      const double eighth = h.volume() / 8;
      const double x = 4 * eighth * weight.xx / (h.x * h.x);
      const double y = 4 * eighth * weight.yy / (h.y * h.y);
      const double z = 4 * eighth * weight.zz / (h.z * h.z);
      const double xy = 4 * eighth * weight.xy / (h.x * h.y);
      const double c = eighth * weight.capacity;
      const auto& r = reference_;
      Hex20Vector column = x * r.slopes[0].col(local) + y * r.slopes[1].col(local) + z * r.slopes[2].col(local);
      if (xy != 0) column += xy * r.cross.col(local);
      if (c != 0) column += c * r.mass.col(local);
      const auto& at = around_.of[local];
      for (int m = 0; m < kHex20; ++m) sum[at[m]] += column[m];
    });
    auto entry = matrix.outerIndexPtr()[node];
    for (int o = 0; o < kReach; ++o) {
      if (!reached[o]) continue;
      const auto point = mesh_.point(I + o % 5 - 2, J + o / 5 % 5 - 2, K + o / 25 - 2);
      matrix.innerIndexPtr()[entry] = mesh_.nodes[point];
      matrix.valuePtr()[entry++] = sum[o];
    }
  }

  const GyroMesh& mesh_;
  const std::vector<BrickWeight>& weights_;
  Around around_;
  const Hex20Integrals& reference_;
};

/// Every pair of nodes of every film face, with what it adds per unit of film.
template <class Visit>
void each_film_entry(const GyroMesh& mesh, Visit visit) {
  const auto& reference = hex20_integrals();
  for (const auto& face : mesh.film) {
    const auto b = static_cast<int>(face.brick);
    const int i = b % mesh.nx();
    const int j = b / mesh.nx() % mesh.ny();
    const int k = b / mesh.nx() / mesh.ny();
    const auto nodes = nodes_of(mesh, i, j, k);
    const double scale = face.factor * edges(mesh, i, j, k).face_area(face.face) / 4;
    for (int n = 0; n < kHex20; ++n)
      for (int m = 0; m < kHex20; ++m)
        if (const double value = reference.face_mass[face.face](n, m); value != 0)
          visit(nodes[n], nodes[m], scale * value);
  }
}

}  // namespace

SparseMatrix assemble_rows(const GyroMesh& mesh, const std::vector<BrickWeight>& weight_of_class) {
  assert(weight_of_class.size() == mesh.classes.size());
  return Rows(mesh, weight_of_class).assemble();
}

SparseMatrix assemble_film(const GyroMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  each_film_entry(mesh, [&](int n, int m, double value) { entries.emplace_back(n, m, value); });
  const auto n = static_cast<Eigen::Index>(mesh.node_count);
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

void add_film(const GyroMesh& mesh, double film_w_per_m2_k, SparseMatrix& matrix) {
  each_film_entry(mesh, [&](int n, int m, double value) { matrix.coeffRef(n, m) += film_w_per_m2_k * value; });
}

}  // namespace gyrotherm
