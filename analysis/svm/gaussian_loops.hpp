// SPDX-License-Identifier: Apache-2.0
/// Inner loops of a sum of Gaussians, in versions for AVX-512, AVX2 and any processor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gyrotherm::svm {

/// Number of centres per block. A block has several rows, each with one number per centre.
inline constexpr std::ptrdiff_t kGaussianBlock = 16;
/// Number of points per loop call. Each number of a block is loaded once for all these points.
inline constexpr std::ptrdiff_t kGaussianTile = 6;

/// Number of bytes of blocks that are applied to all points of a set before the next blocks are loaded: half of a
/// first-level cache.
inline constexpr std::ptrdiff_t kGaussianBytes = 28000;

/// Number of partial sums per point. The sum at the point is their total.
inline constexpr std::ptrdiff_t kGaussianLanes = 8;

/// Loops for one instruction set, over `count` blocks and a tile of points. Coordinate k of point i is points[k ·
/// stride + i]. Sums for point i are added to the partial sums sums[i · kGaussianLanes …]. The relative error of a
/// power is at most 1e-15. All exponents must be at most 1000.
struct GaussianLoops {
  /// Adds the terms of the blocks to the sums at each point. Subtracts the terms of a `negative` block.
  using Loop = void(const double* blocks, const bool* negative, std::ptrdiff_t count, std::ptrdiff_t dimensions,
                    const double* points, std::ptrdiff_t stride, double* sums);
  /// Uses the terms 2^(o_j + Σ_k s_jk u_k). All exponents must be at least −1000. A block consists of the row o, then
  /// one row s per dimension.
  Loop* by_products;
  /// Uses the terms 2^(o_j + a_j Σ_k (u_k − c_jk)²). For a term below 2^−1000 the loop may add 2^−1000 instead. A block
  /// consists of the rows o and a, then one row c per dimension.
  Loop* by_differences;

  /// Uses the terms g = 2^(Σ_k s_jk u_k) w_j. All exponents must be at least −1000. A block consists of the row w, then
  /// one row s per dimension.
  using PairLoop = void(const double* blocks, std::ptrdiff_t count, std::ptrdiff_t dimensions, const double* points,
                        std::ptrdiff_t stride, const double* weights, double* sums, double* centre_sums);
  /// Leaves `weights` and `centre_sums` unused.
  PairLoop* one_way;
  /// Adds each power to the sums of its point and to the sums of its centre. In the sum of a centre, each power is
  /// multiplied by the point's entry of `weights`. centre_sums has kGaussianBlock entries per block.
  PairLoop* both_ways;
};

/// Returns the fastest loops supported by this processor.
[[nodiscard]] const GaussianLoops& gaussian_loops();
/// Returns all loops supported by this processor, the fastest first. The last ones run on any processor.
[[nodiscard]] std::vector<const GaussianLoops*> all_gaussian_loops();

/// Returns the loops for one instruction set, whether or not this processor supports it. Null if they were not built.
[[nodiscard]] const GaussianLoops* gaussian_loops_avx512();
[[nodiscard]] const GaussianLoops* gaussian_loops_avx2();

// The following templates make the loops for one instruction set. Their parameter `Lanes` has these members:
// Line: vector of kWidth doubles. UnalignedLine: the same vector at any address.
// raise<low>(x): x[i] ← 2^x[i] for a tile of lines. Unless `low`, no x may be below −1000.
// add_powers<low>(x, sums): sums[i] += 2^x[i].
// All of them are inlined and thus compiled for the instruction set of their caller.

#define GYROTHERM_INLINE __attribute__((always_inline)) inline
/// Unrolls the next loop over a tile or over lanes early. Its lines then stay in registers.
#define GYROTHERM_UNROLL _Pragma("GCC unroll 16")

template <class Lanes>
GYROTHERM_INLINE void read(const double* from, typename Lanes::Line& line) {
  line = *reinterpret_cast<const typename Lanes::UnalignedLine*>(from);
}

/// Computes x, y += Σ_k s_k u_k for two lines of centres and a tile of points u. The rows s_k begin at `rows`.
template <class Lanes>
GYROTHERM_INLINE void add_products(const double* rows, std::ptrdiff_t dimensions, const double* points,
                                   std::ptrdiff_t stride, typename Lanes::Line (&x)[kGaussianTile],
                                   typename Lanes::Line (&y)[kGaussianTile]) {
  typename Lanes::Line first, second;
  for (std::ptrdiff_t k = 0; k < dimensions; ++k, rows += kGaussianBlock, points += stride) {
    read<Lanes>(rows, first);
    read<Lanes>(rows + Lanes::kWidth, second);
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) {
      x[i] += first * points[i];
      y[i] += second * points[i];
    }
  }
}

/// Exponents by products, for two lines of centres per pass. With one line, loading the points would take longer than
/// the arithmetic.
template <class Lanes>
struct ByProducts {
  using Line = typename Lanes::Line;
  static constexpr std::ptrdiff_t kRowsBefore = 1;
  static constexpr bool kLow = false;

  static GYROTHERM_INLINE void exponents(const double* block, std::ptrdiff_t dimensions, const double* points,
                                         std::ptrdiff_t stride, Line (&x)[kGaussianTile], Line (&y)[kGaussianTile]) {
    Line first, second;
    read<Lanes>(block, first);
    read<Lanes>(block + Lanes::kWidth, second);
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) x[i] = first, y[i] = second;
    add_products<Lanes>(block + kGaussianBlock, dimensions, points, stride, x, y);
  }
};

template <class Lanes>
struct ByDifferences {
  using Line = typename Lanes::Line;
  static constexpr std::ptrdiff_t kRowsBefore = 2;
  static constexpr bool kLow = true;

  static GYROTHERM_INLINE void exponents(const double* block, std::ptrdiff_t dimensions, const double* points,
                                         std::ptrdiff_t stride, Line (&x)[kGaussianTile], Line (&y)[kGaussianTile]) {
    Line offset, offset2, scale, scale2, first, second;
    read<Lanes>(block, offset);
    read<Lanes>(block + Lanes::kWidth, offset2);
    block += kGaussianBlock;
    read<Lanes>(block, scale);
    read<Lanes>(block + Lanes::kWidth, scale2);
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) x[i] = y[i] = Line{};
    for (std::ptrdiff_t k = 0; k < dimensions; ++k, points += stride) {
      block += kGaussianBlock;
      read<Lanes>(block, first);
      read<Lanes>(block + Lanes::kWidth, second);
      GYROTHERM_UNROLL
      for (int i = 0; i < kGaussianTile; ++i) {
        const Line apart = first - points[i], apart2 = second - points[i];
        x[i] += apart * apart;
        y[i] += apart2 * apart2;
      }
    }
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) {
      x[i] = x[i] * scale + offset;
      y[i] = y[i] * scale2 + offset2;
    }
  }
};

/// Lanes as portable vector types of the compiler, `kBytes` per line.
template <int kBytes>
struct PlainLanes {
  typedef double Line __attribute__((vector_size(kBytes)));
  typedef double UnalignedLine __attribute__((vector_size(kBytes), aligned(8), may_alias));
  typedef std::int64_t Bits __attribute__((vector_size(kBytes)));
  static constexpr std::ptrdiff_t kWidth = kBytes / 8;

  // Minimax polynomial of 2^r, |r| ≤ 1/2: relative error 2e-16 before rounding. Highest power first.
  static constexpr int kPowers = 11;
  static constexpr double kPower[kPowers] = {7.037241035574904e-09,
                                             1.0208535284530156e-07,
                                             1.3215663053575365e-06,
                                             1.5252658130958496e-05,
                                             0.00015403529960711067,
                                             0.00133335582285357,
                                             0.009618129108034891,
                                             0.055504108664459,
                                             0.24022650695908768,
                                             0.6931471805599497,
                                             1.0};
  // Adding this constant to a number below 2^51 leaves the number, rounded to an integer, in the low bits of the sum.
  static constexpr double kRounder = 6755399441055744.0;
  static constexpr double kSmallestExponent = -1000;
  static constexpr int kMantissaBits = 52;
  /// Number of interleaved arithmetic chains that fit in 16 registers.
  static constexpr int kInterleavedChains = 3;
  static_assert(kGaussianTile % kInterleavedChains == 0);

  // Computes 2^x = 2^k · 2^r, where k is the integer nearest to x.
  template <bool kLow>
  static GYROTHERM_INLINE void raise(Line (&x)[kGaussianTile]) {
    GYROTHERM_UNROLL
    for (int first = 0; first < kGaussianTile; first += kInterleavedChains) {
      Line rounded[kInterleavedChains], remainder[kInterleavedChains], power[kInterleavedChains];
      GYROTHERM_UNROLL
      for (int i = 0; i < kInterleavedChains; ++i) {
        const Line smallest = Line{} + kSmallestExponent;
        Line held = x[first + i];
        if constexpr (kLow) held = held > smallest ? held : smallest;
        rounded[i] = held + kRounder;
        remainder[i] = held - (rounded[i] - kRounder);
        power[i] = Line{} + kPower[0];
      }
      GYROTHERM_UNROLL
      for (int k = 1; k < kPowers; ++k) {
        GYROTHERM_UNROLL
        for (int i = 0; i < kInterleavedChains; ++i) power[i] = power[i] * remainder[i] + kPower[k];
      }
      GYROTHERM_UNROLL
      for (int i = 0; i < kInterleavedChains; ++i) {
        x[first + i] = reinterpret_cast<Line>(reinterpret_cast<Bits>(power[i]) +
                                              (reinterpret_cast<Bits>(rounded[i]) << kMantissaBits));
      }
    }
  }

  template <bool kLow>
  static GYROTHERM_INLINE void add_powers(Line (&x)[kGaussianTile], Line (&sums)[kGaussianTile]) {
    raise<kLow>(x);
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) sums[i] += x[i];
  }
};

template <class Line>
GYROTHERM_INLINE void negate(Line (&lines)[kGaussianTile]) {
  GYROTHERM_UNROLL
  for (Line& line : lines) line = -line;
}

template <class Lanes, class Exponents>
GYROTHERM_INLINE void add_gaussians(const double* blocks, const bool* negative, std::ptrdiff_t count,
                                    std::ptrdiff_t dimensions, const double* points, std::ptrdiff_t stride,
                                    double* sums) {
  using Line = typename Lanes::Line;
  Line sum[kGaussianTile];
  GYROTHERM_UNROLL
  for (int i = 0; i < kGaussianTile; ++i) read<Lanes>(sums + i * kGaussianLanes, sum[i]);
  for (std::ptrdiff_t b = 0; b < count; ++b) {
    if (negative[b]) negate(sum);
    GYROTHERM_UNROLL
    for (std::ptrdiff_t part = 0; part < kGaussianBlock; part += 2 * Lanes::kWidth) {
      Line x[kGaussianTile], y[kGaussianTile];
      Exponents::exponents(blocks + part, dimensions, points, stride, x, y);
      Lanes::template add_powers<Exponents::kLow>(x, sum);
      Lanes::template add_powers<Exponents::kLow>(y, sum);
    }
    if (negative[b]) negate(sum);
    blocks += (Exponents::kRowsBefore + dimensions) * kGaussianBlock;
  }
  GYROTHERM_UNROLL
  for (int i = 0; i < kGaussianTile; ++i) {
    *reinterpret_cast<typename Lanes::UnalignedLine*>(sums + i * kGaussianLanes) = sum[i];
  }
}

/// Adds the powers of one line of centres to the sums of the tile and, if `kBoth`, to the sums of the centres.
template <class Lanes, bool kBoth>
GYROTHERM_INLINE void share_out(const typename Lanes::Line (&power)[kGaussianTile], const double* centre_weights,
                                const double* weights, typename Lanes::Line (&sum)[kGaussianTile],
                                double* centre_sums) {
  typename Lanes::Line weight;
  read<Lanes>(centre_weights, weight);
  GYROTHERM_UNROLL
  for (int i = 0; i < kGaussianTile; ++i) sum[i] += power[i] * weight;
  if constexpr (kBoth) {
    typename Lanes::Line centre_line;
    read<Lanes>(centre_sums, centre_line);
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) centre_line += power[i] * weights[i];
    *reinterpret_cast<typename Lanes::UnalignedLine*>(centre_sums) = centre_line;
  }
}

template <class Lanes, bool kBoth>
GYROTHERM_INLINE void add_pairs(const double* blocks, std::ptrdiff_t count, std::ptrdiff_t dimensions,
                                const double* points, std::ptrdiff_t stride, const double* weights, double* sums,
                                double* centre_sums) {
  using Line = typename Lanes::Line;
  Line sum[kGaussianTile];
  GYROTHERM_UNROLL
  for (int i = 0; i < kGaussianTile; ++i) read<Lanes>(sums + i * kGaussianLanes, sum[i]);
  for (std::ptrdiff_t b = 0; b < count; ++b, centre_sums += kBoth ? kGaussianBlock : 0) {
    GYROTHERM_UNROLL
    for (std::ptrdiff_t part = 0; part < kGaussianBlock; part += 2 * Lanes::kWidth) {
      Line x[kGaussianTile] = {}, y[kGaussianTile] = {};
      add_products<Lanes>(blocks + kGaussianBlock + part, dimensions, points, stride, x, y);
      Lanes::template raise<false>(x);
      share_out<Lanes, kBoth>(x, blocks + part, weights, sum, centre_sums + part);
      Lanes::template raise<false>(y);
      share_out<Lanes, kBoth>(y, blocks + part + Lanes::kWidth, weights, sum, centre_sums + part + Lanes::kWidth);
    }
    blocks += (1 + dimensions) * kGaussianBlock;
  }
  GYROTHERM_UNROLL
  for (int i = 0; i < kGaussianTile; ++i) {
    *reinterpret_cast<typename Lanes::UnalignedLine*>(sums + i * kGaussianLanes) = sum[i];
  }
}

/// Defines all loops. The file that uses the macro determines their instruction set.
#define GYROTHERM_GAUSSIAN_LOOPS(Lanes)                                                                            \
  void by_products(const double* blocks, const bool* negative, std::ptrdiff_t count, std::ptrdiff_t dimensions,    \
                   const double* points, std::ptrdiff_t stride, double* sums) {                                    \
    add_gaussians<Lanes, ByProducts<Lanes>>(blocks, negative, count, dimensions, points, stride, sums);            \
  }                                                                                                                \
  void by_differences(const double* blocks, const bool* negative, std::ptrdiff_t count, std::ptrdiff_t dimensions, \
                      const double* points, std::ptrdiff_t stride, double* sums) {                                 \
    add_gaussians<Lanes, ByDifferences<Lanes>>(blocks, negative, count, dimensions, points, stride, sums);         \
  }                                                                                                                \
  void one_way(const double* blocks, std::ptrdiff_t count, std::ptrdiff_t dimensions, const double* points,        \
               std::ptrdiff_t stride, const double* weights, double* sums, double* centre_sums) {                  \
    add_pairs<Lanes, false>(blocks, count, dimensions, points, stride, weights, sums, centre_sums);                \
  }                                                                                                                \
  void both_ways(const double* blocks, std::ptrdiff_t count, std::ptrdiff_t dimensions, const double* points,      \
                 std::ptrdiff_t stride, const double* weights, double* sums, double* centre_sums) {                \
    add_pairs<Lanes, true>(blocks, count, dimensions, points, stride, weights, sums, centre_sums);                 \
  }                                                                                                                \
  constexpr GaussianLoops kLoops { by_products, by_differences, one_way, both_ways }

}  // namespace gyrotherm::svm
