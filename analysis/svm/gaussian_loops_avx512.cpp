// SPDX-License-Identifier: Apache-2.0
// Compiled for AVX-512 (see CMakeLists.txt). Must not include code that other object files of the program also compile.
#include "analysis/svm/gaussian_loops.hpp"

#ifdef __AVX512DQ__
#include <immintrin.h>
#endif

namespace gyrotherm::svm {

#ifdef __AVX512DQ__
namespace {

// 2^(i/16).
alignas(64) constexpr double kRoots[16] = {1.0,
                                           1.0442737824274138,
                                           1.0905077326652577,
                                           1.1387886347566916,
                                           1.189207115002721,
                                           1.241857812073484,
                                           1.2968395546510096,
                                           1.3542555469368927,
                                           1.4142135623730951,
                                           1.4768261459394993,
                                           1.5422108254079407,
                                           1.6104903319492543,
                                           1.681792830507429,
                                           1.7562521603732995,
                                           1.8340080864093424,
                                           1.9152065613971474};
// Minimax polynomial of 2^r, 0 ≤ r < 1/16: relative error 7e-18 before rounding. Highest power first.
constexpr double kPower[] = {0.00015740594022796908,
                             0.0013330655280692448,
                             0.0096181414762568,
                             0.055504108394622706,
                             0.24022650696190864,
                             0.6931471805599344,
                             1.0};
// Adding this constant to a number, rounding down, leaves the number of sixteenths in the low bits of the sum.
constexpr double kSixteenths = 6755399441055744.0 / 16;
// Mask of all lanes. (GCC 12 warns about the forms without a mask.)
constexpr __mmask8 kAll = 0xff;
constexpr int kDownToSixteenths = 4 << 4 | _MM_FROUND_TO_NEG_INF;

struct Avx512 {
  using Line = __m512d;
  using UnalignedLine = __m512d_u;
  static constexpr std::ptrdiff_t kWidth = 8;

  template <bool>
  static GYROTHERM_INLINE void raise(Line (&x)[kGaussianTile]) {
    Line power[kGaussianTile], whole[kGaussianTile];
    factors(x, power, whole);
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) x[i] = power[i] * whole[i];
  }

  template <bool>
  static GYROTHERM_INLINE void add_powers(const Line (&x)[kGaussianTile], Line (&sums)[kGaussianTile]) {
    Line power[kGaussianTile], whole[kGaussianTile];
    factors(x, power, whole);
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) sums[i] = _mm512_fmadd_pd(power[i], whole[i], sums[i]);
  }

 private:
  // Splits 2^x = 2^⌊x⌋ · 2^(i/16) · 2^r with i in 0…15 and a remainder r below 1/16. `power` is 2^r and `whole` is the
  // product of the other two.
  static GYROTHERM_INLINE void factors(const Line (&x)[kGaussianTile], Line (&power)[kGaussianTile],
                                       Line (&whole)[kGaussianTile]) {
    const Line low = _mm512_load_pd(kRoots), high = _mm512_load_pd(kRoots + 8);
    Line remainder[kGaussianTile];
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) {
      remainder[i] = _mm512_reduce_pd(x[i], kDownToSixteenths);
      const Line index =
          _mm512_maskz_add_round_pd(kAll, x[i], _mm512_set1_pd(kSixteenths), _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
      whole[i] = _mm512_permutex2var_pd(low, _mm512_castpd_si512(index), high);
      power[i] = _mm512_set1_pd(kPower[0]);
    }
    for (int k = 1; k < 7; ++k) {
      GYROTHERM_UNROLL
      for (int i = 0; i < kGaussianTile; ++i) {
        power[i] = _mm512_fmadd_pd(power[i], remainder[i], _mm512_set1_pd(kPower[k]));
      }
    }
    GYROTHERM_UNROLL
    for (int i = 0; i < kGaussianTile; ++i) whole[i] = _mm512_maskz_scalef_pd(kAll, whole[i], x[i]);
  }
};

GYROTHERM_GAUSSIAN_LOOPS(Avx512);

}  // namespace

const GaussianLoops* gaussian_loops_avx512() { return &kLoops; }
#else
const GaussianLoops* gaussian_loops_avx512() { return nullptr; }
#endif

}  // namespace gyrotherm::svm
