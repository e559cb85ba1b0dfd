#include "core/random_stream.hpp"

#include <cmath>

namespace gyrotherm {

std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

RandomStream::RandomStream(std::uint64_t seed, RandomPurpose purpose)
    : bits_(splitmix64(splitmix64(seed) + static_cast<std::uint64_t>(purpose))) {}

double RandomStream::uniform() { return static_cast<double>(bits_() >> 11U) * 0x1p-53; }

double RandomStream::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double x{};
  double y{};
  double square{};
  do {
    x = 2 * uniform() - 1;
    y = 2 * uniform() - 1;
    square = x * x + y * y;
  } while (square >= 1 || square == 0);
  const double factor = std::sqrt(-2 * std::log(square) / square);
  spare_ = y * factor;
  has_spare_ = true;
  return x * factor;
}

double RandomStream::log_normal(double sigma) { return std::exp(sigma * normal()); }

}  // namespace gyrotherm
