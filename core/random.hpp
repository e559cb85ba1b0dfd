/// Draws that are the same with every standard library, unlike its distributions.
#pragma once

#include <cstdint>
#include <random>

namespace gyrotherm {

/// Uniform in [0, 1), from the upper 53 bits.
[[nodiscard]] inline double uniform(std::mt19937_64& generator) {
  return static_cast<double>(generator() >> 11) * 0x1p-53;
}

/// Uniform in 0 … count − 1.
[[nodiscard]] inline std::int64_t index_below(std::int64_t count, std::mt19937_64& generator) {
  return static_cast<std::int64_t>(uniform(generator) * static_cast<double>(count));
}

}  // namespace gyrotherm
