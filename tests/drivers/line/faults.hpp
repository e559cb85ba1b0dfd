// SPDX-License-Identifier: Apache-2.0
/// Register contents that identify their request, and a seeded random choice of faults in the answers.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "core/quantity.hpp"

namespace gyrotherm::drivers {

/// Returns words that depend on the address and on the request, so no earlier or later answer is correct.
[[nodiscard]] inline std::vector<std::uint16_t> telltale_words(std::uint16_t address, std::size_t count,
                                                               std::uint32_t request) {
  std::vector<std::uint16_t> words(count);
  for (std::size_t i = 0; i < count; ++i)
    words[i] = static_cast<std::uint16_t>((address + i) * 0x9E37u ^ request * 0x85EBu ^ request >> 16);
  return words;
}

/// Random choices that do not depend on the standard library's distributions.
class Chance {
 public:
  explicit Chance(unsigned seed) : engine_(seed) {}
  [[nodiscard]] std::size_t below(std::size_t limit) { return engine_() % limit; }
  [[nodiscard]] bool one_in(std::size_t n) { return below(n) == 0; }
  [[nodiscard]] Duration between(Duration least, Duration most) {
    return least + Duration(static_cast<std::int64_t>(engine_() % static_cast<std::uint64_t>((most - least).count())));
  }
  [[nodiscard]] std::byte byte() { return static_cast<std::byte>(engine_() & 0xFF); }

 private:
  std::mt19937_64 engine_;
};

/// Counts of transactions by their result.
struct Account {
  long good = 0, failed = 0, wrong = 0, faults = 0;
};

#ifdef GYROTHERM_NIGHTLY
inline constexpr long kFaultedTransactions = 1'000'000;
#else
inline constexpr long kFaultedTransactions = 100'000;
#endif

}  // namespace gyrotherm::drivers
