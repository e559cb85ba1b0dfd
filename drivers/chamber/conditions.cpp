#include "drivers/chamber/conditions.hpp"

#include <algorithm>

namespace gyrotherm {

bool holds(const Condition& condition, double value) {
  if (condition.above) return value > *condition.above;
  const auto word = static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
  const bool one_of_them = (word & condition.bits) != 0 || std::ranges::any_of(condition.codes, [&](auto code) {
                             return static_cast<double>(code) == value;
                           });
  return one_of_them != condition.not_these;
}

}  // namespace gyrotherm
