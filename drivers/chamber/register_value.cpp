#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "drivers/chamber/register_item.hpp"

namespace gyrotherm {

namespace {

constexpr double kFahrenheitPerKelvin = 1.8;
constexpr double kFahrenheitAtZeroCelsius = 32;
/// Of a sentinel: a float that went through a scale or two.
constexpr double kSameSentinel = 1e-6;

std::uint16_t swapped(std::uint16_t word) { return static_cast<std::uint16_t>(word << 8 | word >> 8); }

struct Range {
  double low, high;
};
template <class T>
constexpr Range range_of() {
  return {static_cast<double>(std::numeric_limits<T>::lowest()), static_cast<double>(std::numeric_limits<T>::max())};
}
Range range(const RegisterItem& item) {
  switch (item.type) {
    case RegisterType::u16:
    case RegisterType::date_time:
    case RegisterType::text: return range_of<std::uint16_t>();
    case RegisterType::s16: return range_of<std::int16_t>();
    case RegisterType::u32: return range_of<std::uint32_t>();
    case RegisterType::s32: return range_of<std::int32_t>();
    case RegisterType::f32: return range_of<float>();
    case RegisterType::bits: return {0, static_cast<double>((1U << item.bit_count) - 1)};
  }
  return {};
}

/// From this program's value to the instrument's, before its scale, and back.
double to_unit(const RegisterItem& item, double value) {
  if (!item.fahrenheit) return value;
  return value * kFahrenheitPerKelvin + (item.step ? 0 : kFahrenheitAtZeroCelsius);
}
double from_unit(const RegisterItem& item, double value) {
  if (!item.fahrenheit) return value;
  return (value - (item.step ? 0 : kFahrenheitAtZeroCelsius)) / kFahrenheitPerKelvin;
}

std::uint32_t bits_of(const RegisterItem& item, double raw) {
  const auto [low, high] = range(item);
  raw = std::clamp(raw, low, high);
  if (item.type == RegisterType::f32) return std::bit_cast<std::uint32_t>(static_cast<float>(raw));
  const auto whole = static_cast<std::uint32_t>(std::llround(raw));
  return item.type == RegisterType::bits ? whole << item.first_bit : whole;
}

double raw_of(const RegisterItem& item, std::uint32_t bits) {
  switch (item.type) {
    case RegisterType::u16:
    case RegisterType::date_time:
    case RegisterType::text: return static_cast<std::uint16_t>(bits);
    case RegisterType::s16: return static_cast<std::int16_t>(bits);
    case RegisterType::u32: return bits;
    case RegisterType::s32: return static_cast<std::int32_t>(bits);
    case RegisterType::f32: return std::bit_cast<float>(bits);
    case RegisterType::bits: return bits >> item.first_bit & ((1U << item.bit_count) - 1);
  }
  return 0;
}

/// From or to the order abcd; each order is its own inverse.
void reorder(WordOrder order, std::uint16_t& first, std::uint16_t& second) {
  if (order == WordOrder::cdab || order == WordOrder::dcba) std::swap(first, second);
  if (order == WordOrder::badc || order == WordOrder::dcba) first = swapped(first), second = swapped(second);
}

std::vector<std::uint16_t> words_of(const RegisterItem& item, double raw) {
  const auto bits = bits_of(item, raw);
  auto low = static_cast<std::uint16_t>(bits);
  if (word_count(item.type) == 1) return {low};
  auto high = static_cast<std::uint16_t>(bits >> 16);
  reorder(item.order, high, low);
  return {high, low};
}

double writing_scale(const RegisterItem& item) { return item.write_scale.value_or(item.scale); }

std::string in_hex(std::span<const std::uint16_t> words) {
  std::string all;
  for (const auto word : words) all += fmt::format("{}{:04X}", all.empty() ? "" : " ", word);
  return all;
}

}  // namespace

std::uint16_t word_count(RegisterType type) {
  return type == RegisterType::u32 || type == RegisterType::s32 || type == RegisterType::f32 ? 2 : 1;
}

std::uint16_t word_count(const RegisterItem& item) {
  const auto spread = [](std::size_t count, std::uint16_t stride) {
    return static_cast<std::uint16_t>(count == 0 ? 0 : (count - 1) * stride + 1);
  };
  if (item.type == RegisterType::date_time) return spread(item.date.words.size(), item.date.stride);
  if (item.type != RegisterType::text) return word_count(item.type);
  const auto& form = item.text;
  return spread(static_cast<std::size_t>((form.characters + form.per_register - 1) / form.per_register), form.stride);
}

std::string place(const RegisterItem& item) { return fmt::format("chamber register {} ({})", item.address, item.name); }

std::uint16_t with_other_bits(const RegisterItem& item, std::uint16_t word, std::uint16_t present) {
  const auto mask = static_cast<std::uint16_t>(((1U << item.bit_count) - 1) << item.first_bit);
  return static_cast<std::uint16_t>((present & ~mask) | (word & mask));
}

WriteFunction write_function(const std::optional<WriteFunction>& said, std::size_t count) {
  return said.value_or(count == 1 ? WriteFunction::one_register : WriteFunction::registers);
}

RegisterItem in_context(RegisterItem item, const ItemContext& context) {
  if (context.fahrenheit) item.fahrenheit = *context.fahrenheit;
  if (context.decimals) {
    item.scale *= std::pow(10.0, -*context.decimals);
    if (item.write_scale) *item.write_scale *= std::pow(10.0, -*context.decimals);
    item.resolution = item.scale;
  }
  return item;
}

std::vector<std::uint16_t> encode(const RegisterItem& item, double value) {
  assert(std::isfinite(value));
  return words_of(item, (to_unit(item, value) - item.offset) / writing_scale(item));
}

std::vector<std::uint16_t> encode_as_read(const RegisterItem& item, double value) {
  assert(std::isfinite(value));
  return words_of(item, (to_unit(item, value) - item.offset) / item.scale);
}

double raw_value(const RegisterItem& item, std::span<const std::uint16_t> words) {
  assert(words.size() >= word_count(item.type));
  if (word_count(item.type) == 1) return raw_of(item, words[0]);
  auto high = words[0], low = words[1];
  reorder(item.order, high, low);
  return raw_of(item, std::uint32_t{high} << 16 | low);
}

double decode_as_written(const RegisterItem& item, std::span<const std::uint16_t> words) {
  return from_unit(item, raw_value(item, words) * writing_scale(item) + item.offset);
}

Result<double> decode(const RegisterItem& item, std::span<const std::uint16_t> words) {
  assert(words.size() == word_count(item.type));
  const double raw = raw_value(item, words);
  for (const auto& [why, sentinel] : item.sentinels)
    if (std::abs(raw - sentinel) <= kSameSentinel * std::abs(sentinel))
      return failure(FaultKind::out_of_range, item.name, fmt::format("{} ({})", why, in_hex(words)));
  const double value = from_unit(item, raw * item.scale + item.offset);
  if (!std::isfinite(value)) return failure(FaultKind::corrupted, item.name, in_hex(words) + " is not a finite number");
  if ((item.lowest && value < *item.lowest) || (item.highest && value > *item.highest))
    return failure(FaultKind::out_of_range, item.name, fmt::format("{:g} ({}) cannot be", value, in_hex(words)));
  return value;
}

std::string meaning(const RegisterItem& item, double value) {
  for (const auto& [name, codes] : item.codes)
    if (std::ranges::any_of(codes, [&](auto code) { return static_cast<double>(code) == value; })) return name;
  return item.otherwise.empty() ? fmt::format("{:g}", value) : item.otherwise;
}

}  // namespace gyrotherm
