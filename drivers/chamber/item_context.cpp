#include "drivers/chamber/item_context.hpp"

#include <fmt/format.h>

#include <cassert>

namespace gyrotherm {
namespace {

constexpr double kMostDecimals = 6;

const RegisterItem& named(const RegisterMap& map, const std::string& name) {
  const auto* found = map.find(name);
  assert(found && "parse_register_map() lets no such map pass");
  return *found;
}

Result<int> decimals_of(const RegisterItem& item, const ValueOf& value_of) {
  return value_of(item).and_then([&](double decimals) -> Result<int> {
    if (decimals >= 0 && decimals <= kMostDecimals) return static_cast<int>(decimals);
    return failure(FaultKind::corrupted, place(item), fmt::format("{:g} decimals", decimals));
  });
}

Result<bool> fahrenheit_of(const RegisterItem& item, const ValueOf& value_of) {
  return value_of(item).and_then([&](double code) -> Result<bool> {
    const auto word = meaning(item, code);
    if (word == "celsius" || word == "fahrenheit") return word == "fahrenheit";
    return failure(FaultKind::corrupted, place(item), fmt::format("{} is neither celsius nor fahrenheit", word));
  });
}

}  // namespace

Result<ItemContext> context_of(const RegisterMap& map, const RegisterItem& item, const ValueOf& value_of) {
  ItemContext context;
  if (!item.decimals.empty()) {
    const auto decimals = decimals_of(named(map, item.decimals), value_of);
    if (!decimals) return failure(decimals.error());
    context.decimals = *decimals;
  }
  if (!item.unit.empty()) {
    const auto fahrenheit = fahrenheit_of(named(map, item.unit), value_of);
    if (!fahrenheit) return failure(fahrenheit.error());
    context.fahrenheit = *fahrenheit;
  }
  return context;
}

}  // namespace gyrotherm
