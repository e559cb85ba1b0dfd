/// The few hot loops of this room are compiled once per generation of x86-64, and the program takes the best one its
/// processor has when it starts; elsewhere, and under a sanitiser (which cannot yet run at that moment), there is one
/// version. Results agree to rounding between processors, and to the bit on one.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define GYROTHERM_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define GYROTHERM_CLONES
#endif

namespace gyrotherm {

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

}  // namespace gyrotherm
