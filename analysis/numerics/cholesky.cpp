#include "analysis/numerics/cholesky.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/numerics/lanes.hpp"

namespace gyrotherm {
namespace {

// The recursion halves the matrix until a leaf of this order; all work above the leaves is matrix products.
constexpr Eigen::Index kLeaf = 24;

// A product C −= A Bᵀ runs in tiles of 8 × 6, whose sums stay in registers on AVX2 and AVX-512 alike. A is packed in
// blocks of 192 rows and 256 columns (half of an L2 cache of 1 MiB at most), B in blocks of 256 columns.
constexpr Eigen::Index kTileRows = kDoubleLanes;
constexpr Eigen::Index kTileColumns = 6;
constexpr Eigen::Index kBlockRows = 192;
constexpr Eigen::Index kBlockDepth = 256;

enum class Part { whole, lower };

struct Block {
  double* data;
  Eigen::Index stride;

  [[nodiscard]] Block at(Eigen::Index row, Eigen::Index column) const { return {data + row + column * stride, stride}; }
};

// Scratch of one factorisation: packed strips of tiles.
struct Packed {
  std::vector<double> a;
  std::vector<double> b;
};

// Rows first … first + rows of `m` as strips of `height` rows, each strip column after column, the last filled up with
// zeros.
void pack(Block m, Eigen::Index rows, Eigen::Index depth, Eigen::Index height, std::vector<double>& out) {
  const Eigen::Index strips = (rows + height - 1) / height;
  out.resize(static_cast<std::size_t>(strips * height * depth));
  double* next = out.data();
  for (Eigen::Index first = 0; first < rows; first += height) {
    const Eigen::Index used = std::min(height, rows - first);
    for (Eigen::Index column = 0; column < depth; ++column, next += height) {
      std::copy_n(m.at(first, column).data, used, next);
      std::fill(next + used, next + height, 0.0);
    }
  }
}

// c −= a bᵀ for one tile, of which `rows` × `columns` lie inside c.
GYROTHERM_CLONES
void subtract_tile(const double* a, const double* b, Eigen::Index depth, double* c, Eigen::Index stride,
                   Eigen::Index rows, Eigen::Index columns) {
  DoubleLanes sum[kTileColumns] = {};
  for (Eigen::Index k = 0; k < depth; ++k, a += kTileRows, b += kTileColumns) {
    const DoubleLanes line = *reinterpret_cast<const UnalignedDoubleLanes*>(a);
    for (int column = 0; column < kTileColumns; ++column) sum[column] += line * b[column];
  }
  if (rows == kTileRows && columns == kTileColumns) {
    for (int column = 0; column < kTileColumns; ++column) {
      *reinterpret_cast<UnalignedDoubleLanes*>(c + column * stride) -= sum[column];
    }
    return;
  }
  for (Eigen::Index column = 0; column < columns; ++column) {
    for (Eigen::Index row = 0; row < rows; ++row) c[row + column * stride] -= sum[column][row];
  }
}

// C −= A Bᵀ with C rows × columns. Part::lower leaves out the tiles that lie wholly above the diagonal.
void subtract_product(Block a, Block b, Block c, Eigen::Index rows, Eigen::Index columns, Eigen::Index depth, Part part,
                      Packed& packed) {
  for (Eigen::Index from = 0; from < depth; from += kBlockDepth) {
    const Eigen::Index deep = std::min(kBlockDepth, depth - from);
    pack(b.at(0, from), columns, deep, kTileColumns, packed.b);
    for (Eigen::Index top = 0; top < rows; top += kBlockRows) {
      const Eigen::Index high = std::min(kBlockRows, rows - top);
      pack(a.at(top, from), high, deep, kTileRows, packed.a);
      for (Eigen::Index column = 0; column < columns; column += kTileColumns) {
        for (Eigen::Index row = 0; row < high; row += kTileRows) {
          if (part == Part::lower && top + row + kTileRows <= column) continue;
          const Block tile = c.at(top + row, column);
          subtract_tile(packed.a.data() + row * deep, packed.b.data() + column * deep, deep, tile.data, tile.stride,
                        std::min(kTileRows, high - row), std::min(kTileColumns, columns - column));
        }
      }
    }
  }
}

// X ← X L⁻ᵀ for `rows` rows and a leaf L of order n, column by column.
GYROTHERM_CLONES
void divide_leaf(const double* l, Eigen::Index l_stride, double* x, Eigen::Index x_stride, Eigen::Index rows,
                 Eigen::Index n) {
  for (Eigen::Index column = 0; column < n; ++column) {
    double* target = x + column * x_stride;
    for (Eigen::Index before = 0; before < column; ++before) {
      const double factor = l[column + before * l_stride];
      const double* source = x + before * x_stride;
      for (Eigen::Index row = 0; row < rows; ++row) target[row] -= factor * source[row];
    }
    const double scale = 1.0 / l[column + column * l_stride];
    for (Eigen::Index row = 0; row < rows; ++row) target[row] *= scale;
  }
}

// Half of n, rounded up to whole tiles so that the strips of the products are full.
Eigen::Index half(Eigen::Index n) { return (n / 2 + kTileRows - 1) / kTileRows * kTileRows; }

void divide(Block l, Block x, Eigen::Index rows, Eigen::Index n, Packed& packed) {
  if (n <= kLeaf) return divide_leaf(l.data, l.stride, x.data, x.stride, rows, n);
  const Eigen::Index left = half(n);
  divide(l, x, rows, left, packed);
  subtract_product(x, l.at(left, 0), x.at(0, left), rows, n - left, left, Part::whole, packed);
  divide(l.at(left, left), x.at(0, left), rows, n - left, packed);
}

bool factor_leaf(Block a, Eigen::Index n) {
  for (Eigen::Index column = 0; column < n; ++column) {
    double* pivot = a.at(column, column).data;
    if (!(*pivot > 0)) return false;
    *pivot = std::sqrt(*pivot);
    const double scale = 1.0 / *pivot;
    for (Eigen::Index row = 1; row < n - column; ++row) pivot[row] *= scale;
    for (Eigen::Index right = column + 1; right < n; ++right) {
      const double factor = pivot[right - column];
      double* target = a.at(right, right).data;
      const double* source = pivot + (right - column);
      for (Eigen::Index row = 0; row < n - right; ++row) target[row] -= factor * source[row];
    }
  }
  return true;
}

bool factor(Block a, Eigen::Index n, Packed& packed) {
  if (n <= kLeaf) return factor_leaf(a, n);
  const Eigen::Index left = half(n);
  const Eigen::Index right = n - left;
  if (!factor(a, left, packed)) return false;
  divide(a, a.at(left, 0), right, left, packed);
  subtract_product(a.at(left, 0), a.at(left, 0), a.at(left, left), right, right, left, Part::lower, packed);
  return factor(a.at(left, left), right, packed);
}

}  // namespace

bool factor_cholesky(Eigen::Ref<Eigen::MatrixXd> a) {
  Packed packed;
  return factor({a.data(), a.outerStride()}, a.rows(), packed);
}

void solve_cholesky(const Eigen::Ref<const Eigen::MatrixXd>& factor, Eigen::Ref<Eigen::MatrixXd> b) {
  const auto lower = factor.triangularView<Eigen::Lower>();
  lower.solveInPlace(b);
  lower.transpose().solveInPlace(b);
}

}  // namespace gyrotherm
