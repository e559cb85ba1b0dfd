#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

namespace {

std::uint16_t swapped(std::uint16_t word) { return static_cast<std::uint16_t>(word << 8 | word >> 8); }

struct Range {
  double low, high;
};
template <class T>
constexpr Range range_of() {
  return {static_cast<double>(std::numeric_limits<T>::lowest()), static_cast<double>(std::numeric_limits<T>::max())};
}
Range range(RegisterType type) {
  switch (type) {
    case RegisterType::u16: return range_of<std::uint16_t>();
    case RegisterType::s16: return range_of<std::int16_t>();
    case RegisterType::u32: return range_of<std::uint32_t>();
    case RegisterType::s32: return range_of<std::int32_t>();
    case RegisterType::f32: return range_of<float>();
  }
  return {};
}

std::uint32_t bits_of(const RegisterItem& item, double value) {
  const auto [low, high] = range(item.type);
  const double raw = std::clamp(value / item.scale, low, high);
  if (item.type == RegisterType::f32) return std::bit_cast<std::uint32_t>(static_cast<float>(raw));
  return static_cast<std::uint32_t>(std::llround(raw));
}

double value_of(RegisterType type, std::uint32_t bits) {
  switch (type) {
    case RegisterType::u16: return static_cast<std::uint16_t>(bits);
    case RegisterType::s16: return static_cast<std::int16_t>(bits);
    case RegisterType::u32: return bits;
    case RegisterType::s32: return static_cast<std::int32_t>(bits);
    case RegisterType::f32: return std::bit_cast<float>(bits);
  }
  return 0;
}

/// From or to the order abcd; each order is its own inverse.
void reorder(WordOrder order, std::uint16_t& first, std::uint16_t& second) {
  if (order == WordOrder::cdab || order == WordOrder::dcba) std::swap(first, second);
  if (order == WordOrder::badc || order == WordOrder::dcba) first = swapped(first), second = swapped(second);
}

}  // namespace

std::uint16_t word_count(RegisterType type) { return type == RegisterType::u16 || type == RegisterType::s16 ? 1 : 2; }

std::vector<std::uint16_t> encode(const RegisterItem& item, double value) {
  assert(std::isfinite(value));
  const auto bits = bits_of(item, value);
  auto low = static_cast<std::uint16_t>(bits);
  if (word_count(item.type) == 1) return {low};
  auto high = static_cast<std::uint16_t>(bits >> 16);
  reorder(item.order, high, low);
  return {high, low};
}

Result<double> decode(const RegisterItem& item, std::span<const std::uint16_t> words) {
  assert(words.size() == word_count(item.type));
  if (words.size() == 1) return value_of(item.type, words[0]) * item.scale;
  auto high = words[0], low = words[1];
  reorder(item.order, high, low);
  const auto value = value_of(item.type, std::uint32_t{high} << 16 | low) * item.scale;
  if (!std::isfinite(value))
    return failure(FaultKind::corrupted, item.name,
                   fmt::format("{:04X} {:04X} is not a finite number", words[0], words[1]));
  return value;
}

}  // namespace gyrotherm
