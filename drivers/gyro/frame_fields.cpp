// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

namespace gyrotherm::drivers {

namespace {

constexpr double kMaxWhole = 9.2e18;  // below 2^63

std::uint64_t low_mask(unsigned bits) { return bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1; }

std::int64_t sign_extend(std::uint64_t value, unsigned bits) {
  if (bits >= 64) return static_cast<std::int64_t>(value);
  const std::uint64_t sign = std::uint64_t{1} << (bits - 1);
  return static_cast<std::int64_t>((value ^ sign) - sign);
}

std::int64_t extract_slice(const FrameField& field, std::uint64_t whole) {
  const auto slice = whole >> field.low_bit & low_mask(field.bits);
  return is_signed(field.type) ? sign_extend(slice, field.bits) : static_cast<std::int64_t>(slice);
}

bool is_hexadecimal(FieldType type) { return type == FieldType::hexadecimal || type == FieldType::signed_hexadecimal; }

template <class T>
std::optional<T> parse_whole(std::string_view word, int base) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, base);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

double ExactScale::of(double raw) const {
  return std::ldexp(raw * static_cast<double>(numerator) / static_cast<double>(denominator), power_of_two);
}

double RawValue::number(bool is_signed_type) const {
  if (is_real) return real;
  return is_signed_type ? static_cast<double>(whole) : static_cast<double>(static_cast<std::uint64_t>(whole));
}

std::size_t byte_count(FieldType type) {
  constexpr std::uint8_t kTypeSizes[] = {1, 2, 3, 4, 8, 1, 2, 3, 4, 8, 4, 8, 0, 0, 0, 0};
  static_assert(std::size(kTypeSizes) == static_cast<std::size_t>(FieldType::decimal) + 1);
  return kTypeSizes[static_cast<std::size_t>(type)];
}

bool is_signed(FieldType type) {
  return (type >= FieldType::i8 && type <= FieldType::i64) || type == FieldType::signed_hexadecimal ||
         type == FieldType::integer;
}

bool is_real(FieldType type) { return type == FieldType::f32 || type == FieldType::f64 || type == FieldType::decimal; }

bool is_word(FieldType type) { return type >= FieldType::hexadecimal; }

bool is_gyro(FieldRole role) { return role <= FieldRole::integrated_angle; }

bool is_housekeeping(const FrameField& field) {
  return field.role == FieldRole::temperature || (field.role == FieldRole::value && !field.unit.empty());
}

bool is_satisfied(const StatusRule& rule, std::uint32_t status) {
  const auto held = status & rule.mask;
  return held == rule.good || std::find(rule.also_good.begin(), rule.also_good.end(), held) != rule.also_good.end();
}

bool is_counted(const FrameField& field) {
  return !is_real(field.type) && field.zero == 0 &&
         (field.role == FieldRole::pulse_count || field.role == FieldRole::increment);
}

bool is_in_message(const FrameField& field, std::optional<std::uint32_t> id) {
  return field.ids.empty() || (id && std::find(field.ids.begin(), field.ids.end(), *id) != field.ids.end());
}

std::optional<std::size_t> find_field_position(const FrameField& field, std::size_t length) {
  const auto begin = field.offset < 0 ? static_cast<std::ptrdiff_t>(length) + field.offset : field.offset;
  if (begin < 0 || static_cast<std::size_t>(begin) + field.bytes > length) return std::nullopt;
  return static_cast<std::size_t>(begin);
}

std::uint64_t load_bits(std::span<const std::byte> bytes, bool big_endian, unsigned bits_per_byte) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto byte = std::to_integer<std::uint64_t>(bytes[big_endian ? i : bytes.size() - 1 - i]);
    value = value << bits_per_byte | (byte & low_mask(bits_per_byte));
  }
  return value;
}

void store_bits(std::span<std::byte> bytes, bool big_endian, std::uint64_t value, unsigned bits_per_byte) {
  const auto mask = static_cast<std::byte>(low_mask(bits_per_byte));
  for (std::size_t i = 0; i < bytes.size(); ++i, value >>= bits_per_byte) {
    auto& byte = bytes[big_endian ? bytes.size() - 1 - i : i];
    byte = (byte & ~mask) | (static_cast<std::byte>(value & 0xFF) & mask);
  }
}

std::optional<RawValue> read_raw(const FrameField& field, std::span<const std::byte> frame) {
  const auto place = find_field_position(field, frame.size());
  if (!place) return std::nullopt;
  const auto whole = load_bits(frame.subspan(*place, field.bytes), field.big_endian, field.bits_per_byte);
  if ((whole & field.when_mask) != field.when_value) return std::nullopt;
  if (field.type == FieldType::f32)
    return RawValue{.real = std::bit_cast<float>(static_cast<std::uint32_t>(whole)), .is_real = true};
  if (field.type == FieldType::f64) return RawValue{.real = std::bit_cast<double>(whole), .is_real = true};
  return RawValue{.whole = extract_slice(field, whole)};
}

void write_raw(const FrameField& field, std::span<std::byte> frame, const RawValue& raw) {
  const auto place = find_field_position(field, frame.size());
  if (!place) return;
  const auto bytes = frame.subspan(*place, field.bytes);
  std::uint64_t whole = 0;
  if (field.type == FieldType::f32) {
    whole = std::bit_cast<std::uint32_t>(static_cast<float>(raw.real));
  } else if (field.type == FieldType::f64) {
    whole = std::bit_cast<std::uint64_t>(raw.real);
  } else {
    whole = replace_slice(field, load_bits(bytes, field.big_endian, field.bits_per_byte), raw);
  }
  store_bits(bytes, field.big_endian, whole, field.bits_per_byte);
}

std::optional<RawValue> parse_token(const FrameField& field, std::string_view word) {
  if (is_hexadecimal(field.type)) {
    const auto whole = parse_whole<std::uint64_t>(word, 16);
    if (!whole) return std::nullopt;
    return RawValue{.whole = extract_slice(field, *whole)};
  }
  if (word.starts_with("+-")) return std::nullopt;
  if (word.starts_with('+')) word.remove_prefix(1);
  if (field.type == FieldType::integer) {
    const auto whole = parse_whole<std::int64_t>(word, 10);
    if (!whole) return std::nullopt;
    return RawValue{.whole = extract_slice(field, static_cast<std::uint64_t>(*whole))};
  }
  double real{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), real);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return RawValue{.real = real, .is_real = true};
}

std::string print_token(const FrameField& field, const RawValue& raw) {
  if (is_hexadecimal(field.type))
    return fmt::format("{:08x}", (static_cast<std::uint64_t>(raw.whole) & low_mask(field.bits)) << field.low_bit);
  return field.type == FieldType::integer ? fmt::format("{}", raw.whole) : fmt::format("{:.9f}", raw.real);
}

std::uint32_t sequence_number(const FrameField& field, const RawValue& raw) {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(raw.whole) & low_mask(field.bits));
}

std::uint64_t replace_slice(const FrameField& field, std::uint64_t whole, const RawValue& raw) {
  const auto mask = low_mask(field.bits) << field.low_bit;
  whole = (whole & ~mask) | (static_cast<std::uint64_t>(raw.whole) << field.low_bit & mask);
  return (whole & ~field.when_mask) | field.when_value;
}

double apply_scale(const FrameField& field, const RawValue& raw) {
  return field.scale.of(raw.number(is_signed(field.type))) + field.zero;
}

RawValue invert_scale(const FrameField& field, double value) {
  const double raw = (value - field.zero) / field.scale.of(1);
  if (is_real(field.type)) return {.real = raw, .is_real = true};
  return {.whole = std::llround(std::clamp(raw, -kMaxWhole, kMaxWhole))};
}

std::optional<double> arcsec_per(std::string_view unit, FieldRole role) {
  constexpr double kArcsecPerRadian = 180 * 3600 / std::numbers::pi;
  if (role == FieldRole::rate) {
    if (unit == "rad/s") return kArcsecPerRadian;
    if (unit == "deg/s") return 3600.0;
    if (unit == "deg/h") return 1.0;
    return std::nullopt;
  }
  if (unit == "rad") return kArcsecPerRadian;
  if (unit == "deg") return 3600.0;
  if (unit == "arcsec") return 1.0;
  return std::nullopt;
}

}  // namespace gyrotherm::drivers
