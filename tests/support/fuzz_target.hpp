// SPDX-License-Identifier: Apache-2.0
/// Declares fuzz targets. CTest runs all of them in one program, fuzz_test. For libFuzzer, each target is a separate
/// program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace gyrotherm::fuzz {

using Function = int(const std::uint8_t* data, std::size_t size);

/// Registers a target under its name before main() runs.
struct Target {
  Target(const char* name, Function* run);
};

/// Aborts if the invariant does not hold. A fuzzer reports an abort as a finding.
inline void require(bool invariant) {
  if (!invariant) std::abort();
}

}  // namespace gyrotherm::fuzz

// FUZZ_TARGET(name, const std::uint8_t* data, std::size_t size) { … return 0; } defines a target.
#ifdef GYROTHERM_LIBFUZZER
#define FUZZ_TARGET(name, ...) extern "C" int LLVMFuzzerTestOneInput(__VA_ARGS__)
#else
#define FUZZ_TARGET(name, ...)                                                  \
  static int fuzz_##name(__VA_ARGS__);                                          \
  static const ::gyrotherm::fuzz::Target registered_##name(#name, fuzz_##name); \
  static int fuzz_##name(__VA_ARGS__)
#endif
