#include "drivers/chamber/set_point_tolerance.hpp"

#include <algorithm>

#include "drivers/chamber/item_exchange.hpp"

namespace gyrotherm {

Kelvins set_point_tolerance(const RegisterMap& map) {
  constexpr double kTenth = 0.1;
  const auto* item = map.find("set_point");
  if (!item) return {kTenth};
  return {std::max({finest_step(*item), item->tolerance.value_or(0), kTenth})};
}

}  // namespace gyrotherm
