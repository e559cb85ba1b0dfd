// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "analysis/svm/lanes.hpp"

namespace gyrotherm::svm {

namespace {

// The recursion halves the matrix down to leaves of this order. All work above the leaves consists of matrix products.
constexpr Eigen::Index kLeafOrder = 24;

// A product C −= A Bᵀ runs in tiles of 8 × 6. Their sums fit in registers on both AVX2 and AVX-512. A is packed in
// blocks of 192 rows and 256 columns (at most half of a 1 MiB L2 cache), B in blocks of 256 columns.
constexpr Eigen::Index kTileRows = kDoubleLanes;
constexpr Eigen::Index kTileColumns = 6;
constexpr Eigen::Index kStrips = 3;
// Columns subtracted per pass where tiles are not used.
constexpr Eigen::Index kColumnsAtOnce = 4;
constexpr Eigen::Index kBlockRows = 192;
constexpr Eigen::Index kBlockDepth = 256;

enum class Part { whole, lower };

struct Block {
  double* data;
  Eigen::Index stride;

  [[nodiscard]] Block at(Eigen::Index row, Eigen::Index column) const { return {data + row + column * stride, stride}; }
};

// Scratch memory of one factorisation: packed strips of tiles.
struct PackingBuffers {
  std::vector<double> a;
  std::vector<double> b;
};

// Returns the packing buffers of the calling thread. They are kept between factorisations, because allocating their
// pages each time costs more than a small factorisation.
PackingBuffers& scratch() {
  thread_local PackingBuffers packed;
  return packed;
}

// Packs the rows of `m` as strips of `height` rows, each strip column by column. Pads the last strip with zeros.
template <Eigen::Index height>
void pack(Block m, Eigen::Index rows, Eigen::Index depth, std::vector<double>& out) {
  const Eigen::Index strips = (rows + height - 1) / height;
  const auto needed = static_cast<std::size_t>(strips * height * depth);
  if (out.size() < needed) out.resize(needed);
  double* next = out.data();
  for (Eigen::Index first = 0; first < rows; first += height) {
    const Eigen::Index used = std::min(height, rows - first);
    for (Eigen::Index column = 0; column < depth; ++column, next += height) {
      const double* from = m.at(first, column).data;
      if (used == height) {
        std::memcpy(next, from, height * sizeof(double));  // a constant size avoids a call
        continue;
      }
      std::copy_n(from, used, next);
      std::fill(next + used, next + height, 0.0);
    }
  }
}

// Computes c −= a bᵀ for one tile. Only `rows` × `columns` of it are inside c. The sums stay in registers.
template <class Registers>
[[gnu::always_inline]] inline void subtract_tile_in(const double* a, const double* b, Eigen::Index depth, double* c,
                                                    Eigen::Index stride, Eigen::Index rows, Eigen::Index columns) {
  using Doubles = typename Registers::Doubles;
  constexpr int kWidth = sizeof(Doubles) / sizeof(double);
  constexpr int kParts = kTileRows / kWidth;
  Doubles sum[kTileColumns][kParts] = {};
  for (Eigen::Index k = 0; k < depth; ++k, a += kTileRows, b += kTileColumns) {
    Doubles line[kParts];
    for (int part = 0; part < kParts; ++part) line[part] = lanes_at<Doubles>(a + part * kWidth).value;
    for (int column = 0; column < kTileColumns; ++column)
      for (int part = 0; part < kParts; ++part) sum[column][part] += line[part] * b[column];
  }
  if (rows == kTileRows && columns == kTileColumns) {
    for (int column = 0; column < kTileColumns; ++column)
      for (int part = 0; part < kParts; ++part)
        lanes_at<Doubles>(c + column * stride + part * kWidth).value -= sum[column][part];
    return;
  }
  for (Eigen::Index column = 0; column < columns; ++column) {
    for (Eigen::Index row = 0; row < rows; ++row) c[row + column * stride] -= sum[column][row / kWidth][row % kWidth];
  }
}

#if GYROTHERM_HAS_VERSIONS
GYROTHERM_V4
void subtract_tile(const double* a, const double* b, Eigen::Index depth, double* c, Eigen::Index stride,
                   Eigen::Index rows, Eigen::Index columns) {
  subtract_tile_in<Registers64>(a, b, depth, c, stride, rows, columns);
}
GYROTHERM_V3
void subtract_tile(const double* a, const double* b, Eigen::Index depth, double* c, Eigen::Index stride,
                   Eigen::Index rows, Eigen::Index columns) {
  subtract_tile_in<Registers32>(a, b, depth, c, stride, rows, columns);
}
#endif
GYROTHERM_DEFAULT
void subtract_tile(const double* a, const double* b, Eigen::Index depth, double* c, Eigen::Index stride,
                   Eigen::Index rows, Eigen::Index columns) {
  subtract_tile_in<Registers16>(a, b, depth, c, stride, rows, columns);
}

// Computes the same for kStrips whole tiles below each other, to use all registers of AVX-512. Adds the terms of each
// sum in the same order as subtract_tile.
GYROTHERM_CLONES
void subtract_tiles(const double* a, const double* b, Eigen::Index depth, double* c, Eigen::Index stride) {
  DoubleLanes sum[kStrips][kTileColumns] = {};
  for (Eigen::Index k = 0; k < depth; ++k, b += kTileColumns) {
    const double* lines = a + k * kTileRows;
    for (int column = 0; column < kTileColumns; ++column) {
      const DoubleLanes factor = DoubleLanes{} + b[column];
      for (int strip = 0; strip < kStrips; ++strip) {
        sum[strip][column] += lanes_at<DoubleLanes>(lines + strip * depth * kTileRows).value * factor;
      }
    }
  }
  for (int column = 0; column < kTileColumns; ++column) {
    for (int strip = 0; strip < kStrips; ++strip) {
      lanes_at<DoubleLanes>(c + strip * kTileRows + column * stride).value -= sum[strip][column];
    }
  }
}

bool has_many_registers() {
#if defined(__x86_64__)
  static const bool many = __builtin_cpu_supports("avx512f") != 0;
  return many;
#else
  return false;
#endif
}

// Computes C −= A Bᵀ, where C has `rows` rows and `columns` columns. Part::lower skips tiles that are entirely above
// the diagonal.
void subtract_product(Block a, Block b, Block c, Eigen::Index rows, Eigen::Index columns, Eigen::Index depth, Part part,
                      PackingBuffers& packed) {
  const bool in_strips = has_many_registers();
  for (Eigen::Index from = 0; from < depth; from += kBlockDepth) {
    const Eigen::Index deep = std::min(kBlockDepth, depth - from);
    pack<kTileColumns>(b.at(0, from), columns, deep, packed.b);
    for (Eigen::Index top = 0; top < rows; top += kBlockRows) {
      const Eigen::Index high = std::min(kBlockRows, rows - top);
      pack<kTileRows>(a.at(top, from), high, deep, packed.a);
      for (Eigen::Index column = 0; column < columns; column += kTileColumns) {
        const Eigen::Index wide = std::min(kTileColumns, columns - column);
        for (Eigen::Index row = 0; row < high; row += kTileRows) {
          if (part == Part::lower && top + row + kTileRows <= column) continue;
          const Block tile = c.at(top + row, column);
          const double* strip = packed.a.data() + row * deep;
          const double* other = packed.b.data() + column * deep;
          if (in_strips && wide == kTileColumns && row + kStrips * kTileRows <= high) {
            subtract_tiles(strip, other, deep, tile.data, tile.stride);
            row += (kStrips - 1) * kTileRows;
            continue;
          }
          subtract_tile(strip, other, deep, tile.data, tile.stride, std::min(kTileRows, high - row), wide);
        }
      }
    }
  }
}

// Computes X ← X L⁻ᵀ for `rows` rows and a leaf L of order n, column by column.
GYROTHERM_CLONES
void divide_leaf(const double* l, Eigen::Index l_stride, double* x, Eigen::Index x_stride, Eigen::Index rows,
                 Eigen::Index n) {
  for (Eigen::Index column = 0; column < n; ++column) {
    double* target = x + column * x_stride;
    Eigen::Index before = 0;
    for (; before + kColumnsAtOnce <= column; before += kColumnsAtOnce) {
      const double* factors = l + column + before * l_stride;
      const double f0 = factors[0], f1 = factors[l_stride], f2 = factors[2 * l_stride], f3 = factors[3 * l_stride];
      const double *s0 = x + before * x_stride, *s1 = s0 + x_stride, *s2 = s1 + x_stride, *s3 = s2 + x_stride;
      for (Eigen::Index row = 0; row < rows; ++row) {
        target[row] -= (f0 * s0[row] + f1 * s1[row]) + (f2 * s2[row] + f3 * s3[row]);
      }
    }
    for (; before < column; ++before) {
      const double factor = l[column + before * l_stride];
      const double* source = x + before * x_stride;
      for (Eigen::Index row = 0; row < rows; ++row) target[row] -= factor * source[row];
    }
    const double scale = 1.0 / l[column + column * l_stride];
    for (Eigen::Index row = 0; row < rows; ++row) target[row] *= scale;
  }
}

// Returns half of n, rounded up to whole tiles. All strips of the products are then full.
Eigen::Index half_in_tiles(Eigen::Index n) { return (n / 2 + kTileRows - 1) / kTileRows * kTileRows; }

void divide(Block l, Block x, Eigen::Index rows, Eigen::Index n, PackingBuffers& packed) {
  if (n <= kLeafOrder) return divide_leaf(l.data, l.stride, x.data, x.stride, rows, n);
  const Eigen::Index left = half_in_tiles(n);
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

bool factor(Block a, Eigen::Index n, PackingBuffers& packed) {
  if (n <= kLeafOrder) return factor_leaf(a, n);
  const Eigen::Index left = half_in_tiles(n);
  const Eigen::Index right = n - left;
  if (!factor(a, left, packed)) return false;
  divide(a, a.at(left, 0), right, left, packed);
  subtract_product(a.at(left, 0), a.at(left, 0), a.at(left, left), right, right, left, Part::lower, packed);
  return factor(a.at(left, left), right, packed);
}

// Computes x ← L⁻ᵀ L⁻¹ x.
GYROTHERM_CLONES
void solve_column(const double* l, Eigen::Index stride, Eigen::Index n, double* x) {
  for (Eigen::Index top = 0; top < n; top += kColumnsAtOnce) {
    const Eigen::Index end = std::min(n, top + kColumnsAtOnce);
    for (Eigen::Index j = top; j < end; ++j) {
      x[j] /= l[j + j * stride];
      for (Eigen::Index i = j + 1; i < end; ++i) x[i] -= l[i + j * stride] * x[j];
    }
    if (end == n) break;
    const double *l0 = l + top * stride, *l1 = l0 + stride, *l2 = l1 + stride, *l3 = l2 + stride;
    const double x0 = x[top], x1 = x[top + 1], x2 = x[top + 2], x3 = x[top + 3];
    for (Eigen::Index i = end; i < n; ++i) x[i] -= (l0[i] * x0 + l1[i] * x1) + (l2[i] * x2 + l3[i] * x3);
  }
  for (Eigen::Index j = n - 1; j >= 0; --j) {
    const double* column = l + j * stride;
    DoubleLanes lanes = {};
    Eigen::Index i = j + 1;
    for (; i + kDoubleLanes <= n; i += kDoubleLanes) {
      lanes += lanes_at<DoubleLanes>(column + i).value * lanes_at<DoubleLanes>(x + i).value;
    }
    double sum = ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
    for (; i < n; ++i) sum += column[i] * x[i];
    x[j] = (x[j] - sum) / column[j];
  }
}

// Number of rows of L⁻ᵀ computed at a time. L⁻ᵀ is upper triangular, so the leading zeros of these rows are skipped.
constexpr Eigen::Index kInverseRows = 96;

// Returns a matrix as an operand for products and divisions that only read it.
Block read_only_block(const Eigen::Ref<const Eigen::MatrixXd>& m) {
  return {const_cast<double*>(m.data()), m.outerStride()};
}

}  // namespace

bool factor_cholesky(Eigen::Ref<Eigen::MatrixXd> a) { return factor({a.data(), a.outerStride()}, a.rows(), scratch()); }

void solve_cholesky(const Eigen::Ref<const Eigen::MatrixXd>& factor, Eigen::Ref<Eigen::MatrixXd> b) {
  for (Eigen::Index column = 0; column < b.cols(); ++column) {
    solve_column(factor.data(), factor.outerStride(), factor.rows(), b.col(column).data());
  }
}

void subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& a, Eigen::Ref<Eigen::MatrixXd> c) {
  const Block operand = read_only_block(a);
  subtract_product(operand, operand, {c.data(), c.outerStride()}, a.rows(), a.rows(), a.cols(), Part::lower, scratch());
}

Eigen::VectorXd inverse_diagonal(const Eigen::Ref<const Eigen::MatrixXd>& factor) {
  const Eigen::Index n = factor.rows();
  Eigen::VectorXd diagonal(n);
  Eigen::MatrixXd rows;
  for (Eigen::Index top = 0; top < n; top += kInverseRows) {
    const Eigen::Index high = std::min(kInverseRows, n - top);
    rows.setIdentity(high, n - top);
    divide(read_only_block(factor).at(top, top), {rows.data(), rows.outerStride()}, high, n - top, scratch());
    diagonal.segment(top, high) = rows.rowwise().squaredNorm();
  }
  return diagonal;
}

Eigen::MatrixXd inverse_lower(const Eigen::Ref<const Eigen::MatrixXd>& factor) {
  const Eigen::Index n = factor.rows();
  Eigen::MatrixXd upper = Eigen::MatrixXd::Identity(n, n), inverse = Eigen::MatrixXd::Zero(n, n);
  const Block a{upper.data(), n}, c{inverse.data(), n};
  for (Eigen::Index top = 0; top < n; top += kInverseRows) {
    const Eigen::Index high = std::min(kInverseRows, n - top);
    divide(read_only_block(factor).at(top, top), a.at(top, top), high, n - top, scratch());
    subtract_product(a.at(top, top), a.at(0, top), c.at(top, 0), high, top + high, n - top, Part::whole, scratch());
  }
  inverse = -inverse;
  return inverse;
}

}  // namespace gyrotherm::svm
