// SPDX-License-Identifier: Apache-2.0
/// The few hot loops of this room are compiled once per generation of x86-64, and the program takes the best one its
/// processor has when it starts; elsewhere, and under a sanitiser (which cannot yet run at that moment), there is one
/// version. Results agree to rounding between processors, and to the bit on one.
#pragma once

#include <cstddef>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define GYROTHERM_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define GYROTHERM_CLONES
#endif

namespace gyrotherm::svm {

/// A cache line of doubles, for arithmetic in whole lines; `Unaligned…` may be read from and written to any address.
using DoubleLanes = double __attribute__((vector_size(64)));
using UnalignedDoubleLanes = double __attribute__((vector_size(64), aligned(8), may_alias));
inline constexpr int kDoubleLanes = 8;

/// A cache line of floats, and of as many numbers to count them with.
using FloatLanes = float __attribute__((vector_size(64)));
using UnalignedFloatLanes = float __attribute__((vector_size(64), aligned(4), may_alias));
using IndexLanes = int __attribute__((vector_size(64)));
inline constexpr int kFloatLanes = 16;

/// The lanes that begin at `values`.
[[gnu::always_inline]] inline const UnalignedDoubleLanes& lanes_at(const double* values) {
  return *reinterpret_cast<const UnalignedDoubleLanes*>(values);
}
[[gnu::always_inline]] inline const UnalignedFloatLanes& lanes_at(const float* values) {
  return *reinterpret_cast<const UnalignedFloatLanes*>(values);
}

/// x ← exp(x) for each lane, x ≤ 0, to be inlined into the hot loops of each generation of processor: exp(x) = 2^k
/// exp(r), k the integer nearest to x/ln 2, |r| ≤ ln 2/2, exp(r) by its Taylor polynomial. It is right to a relative
/// error below 4e-16; 0 below −708; exp(0) is exactly 1.
[[gnu::always_inline]] inline void exponentiate_lanes(DoubleLanes& x) {
  using Integers = long long __attribute__((vector_size(64)));
  constexpr double kLog2e = 1.4426950408889634074;
  // ln 2 in two parts; the first has zeros in its last bits, so that its product with a small integer is exact.
  constexpr double kLn2High = 6.93145751953125e-1;
  constexpr double kLn2Low = 1.42860682030941723212e-6;
  // Added to a number below 2^51, leaves it rounded to an integer in the low bits of the sum.
  constexpr double kRounder = 6755399441055744.0;
  constexpr double kSmallestExponent = -708.0;
  constexpr int kMantissaBits = 52;
  const Integers in_range = x > kSmallestExponent;
  x = in_range ? x : DoubleLanes{} + kSmallestExponent;
  const DoubleLanes rounded = x * kLog2e + kRounder;
  const DoubleLanes k = rounded - kRounder;
  const DoubleLanes r = (x - k * kLn2High) - k * kLn2Low;
  DoubleLanes p = DoubleLanes{} + 1.0 / 479001600;
  p = p * r + 1.0 / 39916800;
  p = p * r + 1.0 / 3628800;
  p = p * r + 1.0 / 362880;
  p = p * r + 1.0 / 40320;
  p = p * r + 1.0 / 5040;
  p = p * r + 1.0 / 720;
  p = p * r + 1.0 / 120;
  p = p * r + 1.0 / 24;
  p = p * r + 1.0 / 6;
  p = p * r + 0.5;
  p = p * r + 1.0;
  p = p * r + 1.0;
  const Integers bits = reinterpret_cast<Integers>(p) + (reinterpret_cast<Integers>(rounded) << kMantissaBits);
  x = in_range ? reinterpret_cast<DoubleLanes>(bits) : DoubleLanes{};
}

/// exp of each lane in single precision: relative error below 3e-7; 0 below −87.
[[gnu::always_inline]] inline void exponentiate_lanes(FloatLanes& x) {
  constexpr float kLog2e = 1.44269504F;
  constexpr float kLn2High = 0.693359375F;
  constexpr float kLn2Low = -2.12194440e-4F;
  constexpr float kRounder = 12582912.0F;
  constexpr float kSmallestExponent = -87.0F;
  constexpr int kMantissaBits = 23;
  const IndexLanes in_range = x > kSmallestExponent;
  x = in_range ? x : FloatLanes{} + kSmallestExponent;
  const FloatLanes rounded = x * kLog2e + kRounder;
  const FloatLanes k = rounded - kRounder;
  const FloatLanes r = (x - k * kLn2High) - k * kLn2Low;
  FloatLanes p = FloatLanes{} + 1.0F / 5040;
  p = p * r + 1.0F / 720;
  p = p * r + 1.0F / 120;
  p = p * r + 1.0F / 24;
  p = p * r + 1.0F / 6;
  p = p * r + 0.5F;
  p = p * r + 1.0F;
  p = p * r + 1.0F;
  const IndexLanes bits = reinterpret_cast<IndexLanes>(p) + (reinterpret_cast<IndexLanes>(rounded) << kMantissaBits);
  x = in_range ? reinterpret_cast<FloatLanes>(bits) : FloatLanes{};
}

/// exp of a whole array, several times faster than one call per element: out_i = exp(scale · v_i) to a relative error
/// below 4e-16, for `count` values with scale · v_i ≤ 0; 0 where that is below −708. exp(0) is exactly 1. `out` may be
/// `values`.
void exponentiate(const double* values, std::ptrdiff_t count, double scale, double* out);

}  // namespace gyrotherm::svm
