// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/lanes.hpp"

#include <bit>
#include <cstdint>

namespace gyrotherm::svm {
namespace {

constexpr double kLog2e = 1.4426950408889634074;
// ln 2 in two parts; the first has zeros in its last bits, so that its product with a small integer is exact.
constexpr double kLn2High = 6.93145751953125e-1;
constexpr double kLn2Low = 1.42860682030941723212e-6;
// Added to a number below 2^51, leaves it rounded to an integer in the low bits of the sum.
constexpr double kRounder = 6755399441055744.0;
constexpr double kSmallestExponent = -708.0;
constexpr int kMantissaBits = 52;

}  // namespace

// exp(x) = 2^k exp(r), k the integer nearest to x/ln 2, |r| ≤ ln 2/2, exp(r) by its Taylor polynomial of degree 12.
GYROTHERM_CLONES
void exponentiate(const double* values, std::ptrdiff_t count, double scale, double* out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double product = values[i] * scale;
    const double x = product > kSmallestExponent ? product : kSmallestExponent;
    const double rounded = x * kLog2e + kRounder;
    const double k = rounded - kRounder;
    const double r = (x - k * kLn2High) - k * kLn2Low;
    double p = 1.0 / 479001600;
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
    const auto power = static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(rounded) << kMantissaBits);
    const double scaled = std::bit_cast<double>(std::bit_cast<std::int64_t>(p) + power);
    out[i] = product > kSmallestExponent ? scaled : 0.0;
  }
}

}  // namespace gyrotherm::svm
