// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the parser of terms. A parsed term must be parsed again from its own text.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "analysis/data/features.hpp"
#include "tests/support/fuzz_target.hpp"

namespace {

void read(const std::string& typed) {
  const std::vector<std::string> thermometers = {"A", "B", "die", "die-cap", "x*y", "rate:z"};
  const auto term = gyrotherm::data::parse_term(typed, thermometers);
  if (!term) return;
  if (term->factors.empty() || term->factors.size() > gyrotherm::data::kMostFactors) std::abort();
  const auto again = gyrotherm::data::parse_term(gyrotherm::data::to_string(*term), thermometers);
  if (!again || *again != *term) std::abort();
}

/// Composes a text from pieces of the grammar, so many inputs are nearly valid.
std::string compose_term(const std::uint8_t* data, std::size_t size) {
  constexpr std::array kPieces = {"A", "B", "die", "die-cap", "x*y", "z", "-", "*", "^2", "^3", "rate:", "cap"};
  std::string typed;
  for (std::size_t i = 0; i < size && i < 9; ++i) typed += kPieces[data[i] % kPieces.size()];
  return typed;
}

}  // namespace

FUZZ_TARGET(term, const std::uint8_t* data, std::size_t size) {
  read({reinterpret_cast<const char*>(data), size});
  for (std::size_t length = 1; length <= 9 && length <= size; ++length) read(compose_term(data, length));
  return 0;
}
