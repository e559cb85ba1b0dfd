// SPDX-License-Identifier: Apache-2.0
/// Parses arbitrary bytes as a type-prior file. A parsed prior must be the same after it is written and read again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "analysis/population/type_prior.hpp"
#include "tests/support/fuzz_target.hpp"

FUZZ_TARGET(type_prior_json, const std::uint8_t* data, std::size_t size) {
  const auto prior = gyrotherm::population::type_prior_from_json({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!prior) return 0;
  const std::string json = to_json(*prior);
  const auto again = gyrotherm::population::type_prior_from_json(json, "fuzz");
  if (!again || to_json(*again) != json) std::abort();
  return 0;
}
