// SPDX-License-Identifier: Apache-2.0
/// Vector types and exponentials for the hot loops of this module. These loops are compiled once per x86-64 generation,
/// and the program selects the best version for its processor at startup. There is only one version on other
/// architectures, and under a sanitiser, which cannot run that early. Results of different processors agree to
/// rounding; results of one processor are bit-identical.
#pragma once

#include <cstddef>
#include <iterator>
#include <utility>

// Comparisons and choices between vectors are fast only if one register holds a vector: without AVX-512, GCC 12 splits
// those of 64 bytes into single elements. Loops with comparisons therefore have one version for each size of register:
// an inlined template with the vectors as parameters, and a function for each generation that calls it.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define GYROTHERM_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define GYROTHERM_HAS_VERSIONS 1
#define GYROTHERM_V4 __attribute__((target("arch=x86-64-v4")))
#define GYROTHERM_V3 __attribute__((target("arch=x86-64-v3")))
#define GYROTHERM_DEFAULT __attribute__((target("default")))
#else
#define GYROTHERM_CLONES
#define GYROTHERM_HAS_VERSIONS 0
#define GYROTHERM_DEFAULT
#endif

namespace gyrotherm::svm {

/// One cache line of doubles, for arithmetic in whole lines.
using DoubleLanes = double __attribute__((vector_size(64)));
using LongLanes = long long __attribute__((vector_size(64)));
inline constexpr int kDoubleLanes = 8;

/// One cache line of floats, and one of integers with the same number of lanes, for indices.
using FloatLanes = float __attribute__((vector_size(64)));
using IndexLanes = int __attribute__((vector_size(64)));
inline constexpr int kFloatLanes = 16;

/// Vectors of one register: 64, 32 or 16 bytes. A template gets the type for its arithmetic.
struct Registers64 {
  using Floats = FloatLanes;
  using Indices = IndexLanes;
  using Doubles = DoubleLanes;
  using Longs = LongLanes;
};
struct Registers32 {
  using Floats = float __attribute__((vector_size(32)));
  using Indices = int __attribute__((vector_size(32)));
  using Doubles = double __attribute__((vector_size(32)));
  using Longs = long long __attribute__((vector_size(32)));
};
struct Registers16 {
  using Floats = float __attribute__((vector_size(16)));
  using Indices = int __attribute__((vector_size(16)));
  using Doubles = double __attribute__((vector_size(16)));
  using Longs = long long __attribute__((vector_size(16)));
};

/// Lanes at any address. A vector type with the attribute `aligned` is not enough: Clang and template arguments drop
/// it.
template <class Lanes>
struct [[gnu::packed, gnu::may_alias]] UnalignedLanes {
  Lanes value;
};

/// Returns the lanes that begin at `values`.
template <class Lanes, class Real>
[[gnu::always_inline]] inline const UnalignedLanes<Lanes>& lanes_at(const Real* values) {
  return *reinterpret_cast<const UnalignedLanes<Lanes>*>(values);
}
template <class Lanes, class Real>
[[gnu::always_inline]] inline UnalignedLanes<Lanes>& lanes_at(Real* values) {
  return *reinterpret_cast<UnalignedLanes<Lanes>*>(values);
}

/// Constants of exp in one precision. ln 2 is split in two parts; the last bits of the first are zero, so its product
/// with a small integer is exact. Adding kRounder to a small number leaves it, rounded to an integer, in the low bits
/// of the sum. Below kSmallestExponent exp is 0. The Taylor polynomial has its highest power first.
template <class Real>
struct Exponential;
template <>
struct Exponential<double> {
  static constexpr double kLog2e = 1.4426950408889634074, kLn2High = 6.93145751953125e-1;
  static constexpr double kLn2Low = 1.42860682030941723212e-6, kRounder = 6755399441055744.0;
  static constexpr double kSmallestExponent = -708.0;
  static constexpr int kMantissaBits = 52;
  static constexpr double kTaylor[] = {
      1.0 / 479001600, 1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320, 1.0 / 5040, 1.0 / 720,
      1.0 / 120,       1.0 / 24,       1.0 / 6,       0.5,          1.0,         1.0};
};
template <>
struct Exponential<float> {
  static constexpr float kLog2e = 1.44269504F, kLn2High = 0.693359375F;
  static constexpr float kLn2Low = -2.12194440e-4F, kRounder = 12582912.0F;
  static constexpr float kSmallestExponent = -87.0F;
  static constexpr int kMantissaBits = 23;
  static constexpr float kTaylor[] = {1.0F / 5040, 1.0F / 720, 1.0F / 120, 1.0F / 24, 1.0F / 6, 0.5F, 1.0F, 1.0F};
};

/// Computes x ← exp(x), x ≤ 0, for a number or for each lane of a line, as exp(x) = 2^k exp(r) with k the integer
/// nearest to x/ln 2 and |r| ≤ ln 2/2. The function is inlined, so the hot loops of each processor generation contain
/// their own version. `Integers` has the same size and number of lanes as x. In double precision the relative error is
/// below 4e-16, the result is 0 below −708, and exp(0) is exactly 1. In single precision the relative error is below
/// 3e-7 and the result is 0 below −87.
template <class Real, class Integers, class Numbers>
[[gnu::always_inline]] inline void exponentiate(Numbers& x) {
  using Of = Exponential<Real>;
  const auto in_range = x > Of::kSmallestExponent;
  x = in_range ? x : Numbers{} + Of::kSmallestExponent;
  const Numbers rounded = x * Of::kLog2e + Of::kRounder;
  const Numbers k = rounded - Of::kRounder;
  const Numbers r = (x - k * Of::kLn2High) - k * Of::kLn2Low;
  Numbers p = Numbers{} + Of::kTaylor[0];
  const auto add = [&]<std::size_t... i>(std::index_sequence<i...>) __attribute__((always_inline)) {
    ((p = p * r + Of::kTaylor[i + 1]), ...);
  };
  add(std::make_index_sequence<std::size(Of::kTaylor) - 1>());
  const Integers bits = __builtin_bit_cast(Integers, p) + (__builtin_bit_cast(Integers, rounded) << Of::kMantissaBits);
  x = in_range ? __builtin_bit_cast(Numbers, bits) : Numbers{};
}

/// Computes out_i = exp(scale · v_i) for `count` values with scale · v_i ≤ 0, several times faster than one call per
/// element. The relative error is below 4e-16. The result is 0 below −708, and exp(0) is exactly 1. `out` may be
/// `values`.
void exponentiate(const double* values, std::ptrdiff_t count, double scale, double* out);

}  // namespace gyrotherm::svm
