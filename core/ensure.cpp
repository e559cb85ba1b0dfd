#include "core/ensure.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

namespace gyrotherm {

void ensure(bool holds, const char* law) {
  if (holds) return;
  fmt::print(stderr, "gyrotherm: a law of safety is broken, the program ends: {}\n", law);
  std::fflush(stderr);
  std::abort();
}

}  // namespace gyrotherm
