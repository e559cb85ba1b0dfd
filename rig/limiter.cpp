#include "rig/limiter.hpp"

#include <fmt/format.h>

namespace gyrotherm {
namespace {

std::optional<Celsius> read_side(const TomlTable& table, const char* key) {
  if (!table.has(key)) return {};
  return table.celsius(key);
}

}  // namespace

std::optional<Limiter> read_limiter(const TomlTable& chamber, Celsius lowest, Celsius highest) {
  if (!chamber.has("limiter")) return {};
  const auto table = chamber.table("limiter");
  Limiter limiter{.protection_class = table.choice("class", {"1", "2", "3.1", "3.2", "3.3"}),
                  .lowest = read_side(table, "lowest"),
                  .highest = read_side(table, "highest")};
  if (!limiter.lowest && !limiter.highest) table.mistake("", "expected lowest, highest or both: what it is set to");
  if (limiter.lowest && *limiter.lowest >= lowest)
    table.mistake("lowest", "the limiter would trip at a set point that the chamber may be given");
  if (limiter.highest && *limiter.highest <= highest)
    table.mistake("highest", "the limiter would trip at a set point that the chamber may be given");
  return limiter;
}

std::string in_words(const Limiter& limiter) {
  auto text = "class " + limiter.protection_class;
  if (limiter.lowest) text += fmt::format(", below {:g} °C", limiter.lowest->value);
  if (limiter.highest) text += fmt::format(", above {:g} °C", limiter.highest->value);
  return text;
}

}  // namespace gyrotherm
