/// The inner loops of a sum of Gaussians, for AVX-512, for AVX2 and for any processor.
#pragma once

#include <cstddef>
#include <vector>

namespace gyrotherm {

/// Centres come in blocks of this many; a block is a few rows of one number for each of its centres.
inline constexpr std::ptrdiff_t kGaussianBlock = 16;
/// Points go through a loop this many at once, so that each number of a block is fetched once for all of them.
inline constexpr std::ptrdiff_t kGaussianTile = 6;

/// Sums are kept in lanes, a few parts each: their parts add up to them.
inline constexpr std::ptrdiff_t kGaussianLanes = 8;

/// Each adds to the lanes sums[i · kGaussianLanes …] the terms of `count` blocks at point i of a tile, whose coordinate
/// k is points[k · stride + i]; those of a `negative` block are subtracted. A power is right to 1e-15 of itself. No
/// exponent is above 1000.
struct GaussianLoops {
  using Loop = void(const double* blocks, const bool* negative, std::ptrdiff_t count, std::ptrdiff_t dimensions,
                    const double* points, std::ptrdiff_t stride, double* sums);
  /// 2^(o_j + Σ_k s_jk u_k), no exponent below −1000. Rows of a block: o, then s of each dimension.
  Loop* by_products;
  /// 2^(o_j + a_j Σ_k (u_k − c_jk)²), where that is below 2^−1000 perhaps 2^−1000. Rows of a block: o, a, then c of
  /// each dimension.
  Loop* by_differences;
};

/// The fastest that this processor has.
[[nodiscard]] const GaussianLoops& gaussian_loops();
/// All that this processor has, the fastest first; the last is for any.
[[nodiscard]] std::vector<const GaussianLoops*> all_gaussian_loops();

/// Those for one instruction set, whether or not this processor has it; null where they have not been built.
[[nodiscard]] const GaussianLoops* gaussian_loops_avx512();
[[nodiscard]] const GaussianLoops* gaussian_loops_avx2();

}  // namespace gyrotherm
