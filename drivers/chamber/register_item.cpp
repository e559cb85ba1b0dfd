// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/register_item.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr double kFahrenheitPerKelvin = 1.8;
constexpr double kFahrenheitAtZeroCelsius = 32;
/// Relative tolerance for a sentinel, for the rounding of a float by one or two scalings.
constexpr double kSameSentinel = 1e-6;

std::uint16_t swap_bytes(std::uint16_t word) { return static_cast<std::uint16_t>(word << 8 | word >> 8); }

struct Range {
  double low, high;
};
template <class T>
constexpr Range type_range() {
  return {static_cast<double>(std::numeric_limits<T>::lowest()), static_cast<double>(std::numeric_limits<T>::max())};
}
Range range(const RegisterItem& item) {
  switch (item.type) {
    case RegisterType::u16:
    case RegisterType::date_time:
    case RegisterType::text: return type_range<std::uint16_t>();
    case RegisterType::s16: return type_range<std::int16_t>();
    case RegisterType::u32: return type_range<std::uint32_t>();
    case RegisterType::s32: return type_range<std::int32_t>();
    case RegisterType::f32: return type_range<float>();
    case RegisterType::f64: return type_range<double>();
    case RegisterType::bits: return {0, static_cast<double>((1U << item.bit_count) - 1)};
  }
  return {};
}

/// Converts a value in °C to the instrument's unit, before its scale. from_unit() converts back.
double to_unit(const RegisterItem& item, double value) {
  if (!item.fahrenheit) return value;
  return value * kFahrenheitPerKelvin + (item.step ? 0 : kFahrenheitAtZeroCelsius);
}
double from_unit(const RegisterItem& item, double value) {
  if (!item.fahrenheit) return value;
  return (value - (item.step ? 0 : kFahrenheitAtZeroCelsius)) / kFahrenheitPerKelvin;
}

std::uint32_t to_bits(const RegisterItem& item, double raw) {
  const auto [low, high] = range(item);
  raw = std::clamp(raw, low, high);
  if (item.type == RegisterType::f32) return std::bit_cast<std::uint32_t>(static_cast<float>(raw));
  const auto whole = static_cast<std::uint32_t>(std::llround(raw));
  return item.type == RegisterType::bits ? whole << item.first_bit : whole;
}

double from_bits(const RegisterItem& item, std::uint32_t bits) {
  switch (item.type) {
    case RegisterType::u16:
    case RegisterType::date_time:
    case RegisterType::text: return static_cast<std::uint16_t>(bits);
    case RegisterType::s16: return static_cast<std::int16_t>(bits);
    case RegisterType::u32: return bits;
    case RegisterType::s32: return static_cast<std::int32_t>(bits);
    case RegisterType::f32: return std::bit_cast<float>(bits);
    case RegisterType::f64: break;  // four registers, see raw_value()
    case RegisterType::bits: return bits >> item.first_bit & ((1U << item.bit_count) - 1);
  }
  return 0;
}

/// Converts words from or to the order abcd; each order is its own inverse.
void reorder(WordOrder order, std::span<std::uint16_t> words) {
  if (order == WordOrder::cdab || order == WordOrder::dcba) std::ranges::reverse(words);
  if (order == WordOrder::badc || order == WordOrder::dcba)
    for (auto& word : words) word = swap_bytes(word);
}

constexpr std::size_t kWordsOfDouble = 4;
constexpr int kBitsPerWord = 16;

std::vector<std::uint16_t> to_words(const RegisterItem& item, double raw) {
  const auto bits = item.type == RegisterType::f64 ? std::bit_cast<std::uint64_t>(raw) : to_bits(item, raw);
  const std::size_t count = word_count(item.type);
  std::vector<std::uint16_t> words(count);
  for (std::size_t i = 0; i < count; ++i) words[count - 1 - i] = static_cast<std::uint16_t>(bits >> (i * kBitsPerWord));
  if (count > 1) reorder(item.order, words);
  return words;
}

double written_scale(const RegisterItem& item) { return item.write_scale.value_or(item.scale); }

std::string to_hex(std::span<const std::uint16_t> words) {
  std::string all;
  for (const auto word : words) all += fmt::format("{}{:04X}", all.empty() ? "" : " ", word);
  return all;
}

using std::chrono::sys_days;
using std::chrono::year;

constexpr char kNotPrintable = '?';

char to_printable(char byte) { return byte >= 0x20 && byte < 0x7F ? byte : kNotPrintable; }

/// Returns the day of the week; 0 is Sunday.
int weekday(const CivilTime& time) {
  return static_cast<int>(std::chrono::weekday(sys_days(year(time.year) / time.month / time.day)).c_encoding());
}

/// Members of CivilTime in the order of DatePart; null for the weekday.
constexpr int CivilTime::*kParts[] = {&CivilTime::year, &CivilTime::month,  &CivilTime::day,   nullptr,
                                      &CivilTime::hour, &CivilTime::minute, &CivilTime::second};

int part(const DateForm& form, const CivilTime& time, DatePart which) {
  if (which == DatePart::weekday) return weekday(time);
  return time.*kParts[static_cast<std::size_t>(which)] - (which == DatePart::year ? form.century : 0);
}

void set_part(const DateForm& form, CivilTime& time, DatePart which, int value) {
  if (which == DatePart::weekday) return;
  time.*kParts[static_cast<std::size_t>(which)] = value + (which == DatePart::year ? form.century : 0);
}

bool is_valid_time(const CivilTime& t) {
  const auto of = [](int value) { return static_cast<unsigned>(value); };
  return t.year >= 1970 && t.year < 2200 && (year(t.year) / of(t.month) / of(t.day)).ok() && t.hour < 24 &&
         t.minute < 60 && t.second < 60;
}

}  // namespace

std::uint16_t word_count(RegisterType type) {
  if (type == RegisterType::f64) return kWordsOfDouble;
  return type == RegisterType::u32 || type == RegisterType::s32 || type == RegisterType::f32 ? 2 : 1;
}

std::uint16_t word_count(const RegisterItem& item) {
  const auto spread = [](std::size_t count, std::uint16_t stride) {
    return static_cast<std::uint16_t>(count == 0 ? 0 : (count - 1) * stride + 1);
  };
  if (item.type == RegisterType::date_time) return spread(item.date.words.size(), item.date.stride);
  if (item.type != RegisterType::text) return word_count(item.type);
  const auto& form = item.text;
  const int registers = (form.characters + form.per_register - 1) / form.per_register;
  return spread(static_cast<std::size_t>(registers), form.stride);
}

std::string place(const RegisterItem& item) {
  if (!item.line.empty()) return fmt::format("chamber item {} ({})", item.name, item.line);
  return fmt::format("chamber register {} ({})", item.address, item.name);
}

std::uint16_t merge_bits(const RegisterItem& item, std::uint16_t word, std::uint16_t present) {
  const auto mask = static_cast<std::uint16_t>(((1U << item.bit_count) - 1) << item.first_bit);
  return static_cast<std::uint16_t>((present & ~mask) | (word & mask));
}

WriteFunction write_function(const std::optional<WriteFunction>& specified, std::size_t count) {
  return specified.value_or(count == 1 ? WriteFunction::one_register : WriteFunction::registers);
}

RegisterItem apply_context(RegisterItem item, const ItemContext& context) {
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
  return to_words(item, (to_unit(item, value) - item.offset) / written_scale(item));
}

std::vector<std::uint16_t> encode_as_read(const RegisterItem& item, double value) {
  assert(std::isfinite(value));
  return to_words(item, (to_unit(item, value) - item.offset) / item.scale);
}

double raw_value(const RegisterItem& item, std::span<const std::uint16_t> words) {
  assert(words.size() >= word_count(item.type));
  const std::size_t count = word_count(item.type);
  if (count == 1) return from_bits(item, words[0]);
  std::array<std::uint16_t, kWordsOfDouble> ordered{};
  std::ranges::copy(words.first(count), ordered.begin());
  reorder(item.order, std::span(ordered).first(count));
  std::uint64_t bits = 0;
  for (const auto word : std::span(ordered).first(count)) bits = bits << kBitsPerWord | word;
  if (item.type == RegisterType::f64) return std::bit_cast<double>(bits);
  return from_bits(item, static_cast<std::uint32_t>(bits));
}

double decode_as_written(const RegisterItem& item, std::span<const std::uint16_t> words) {
  return from_unit(item, raw_value(item, words) * written_scale(item) + item.offset);
}

Result<double> decode(const RegisterItem& item, std::span<const std::uint16_t> words) {
  assert(words.size() == word_count(item.type));
  const double raw = raw_value(item, words);
  for (const auto& [why, sentinel] : item.sentinels)
    if (std::abs(raw - sentinel) <= kSameSentinel * std::abs(sentinel))
      return failure(FaultKind::out_of_range, item.name, fmt::format("{} ({})", why, to_hex(words)));
  const double value = from_unit(item, raw * item.scale + item.offset);
  if (!std::isfinite(value))
    return failure(FaultKind::corrupted, item.name,
                   fmt::format("{} is not a finite number; check the word order", to_hex(words)));
  if ((item.lowest && value < *item.lowest) || (item.highest && value > *item.highest))
    return failure(FaultKind::out_of_range, item.name,
                   fmt::format("{:g} ({}) is an impossible value", value, to_hex(words)));
  return value;
}

double UnknownTexts::assign_number(std::string_view text) {
  constexpr std::size_t kMostTexts = 16;
  const std::lock_guard lock(mutex_);
  auto found = std::ranges::find(texts_, text);
  if (found == texts_.end() && texts_.size() < kMostTexts) found = texts_.emplace(found, text);
  return -1.0 - static_cast<double>(found - texts_.begin());
}

std::optional<std::string> UnknownTexts::find_text(double number) const {
  const std::lock_guard lock(mutex_);
  const double position = -1.0 - number;
  if (!(position >= 0) || position >= static_cast<double>(texts_.size())) return std::nullopt;
  return texts_[static_cast<std::size_t>(position)];
}

std::string describe_shared_code(const RegisterItem& item, std::span<const std::string> texts) {
  std::map<std::int64_t, std::string> names;
  for (const auto& [name, codes] : item.codes)
    for (const auto code : codes) {
      const auto [other, is_new] = names.emplace(code, name);
      if (is_new || other->second == name) continue;
      const auto position = static_cast<std::size_t>(code);
      return fmt::format(
          "{} and {} are both {}", other->second, name,
          position < texts.size() ? fmt::format("\"{}\"", plain(texts[position])) : fmt::format("{}", code));
    }
  return {};
}

std::string describe_unreachable_name(const RegisterItem& item) {
  const bool is_number = item.type != RegisterType::text && item.type != RegisterType::date_time;
  if (!is_number && !(item.codes.empty() && item.flags.empty()))
    return fmt::format("\"{}\" is not a number, and has no codes or flags", item.name);
  if (!item.flags.empty() && (item.scale != 1 || item.offset != 0 || item.fahrenheit || !item.decimals.empty()))
    return fmt::format("\"{}\" has flags, which have no scale, offset or unit", item.name);
  for (const auto& [flag, bit] : item.flags) {
    if (item.codes.contains(flag) || flag == item.otherwise)
      return fmt::format("\"{}\" is the name of a flag and of a code", flag);
    if (const auto least = std::ldexp(1.0, bit); item.highest && least > *item.highest)
      return fmt::format("the flag \"{}\" is never set: a value above {:g} is impossible", flag, *item.highest);
  }
  if (!item.readable || !item.decimals.empty() || !item.unit.empty()) return {};
  for (const auto& [name, codes] : item.codes)
    for (const auto code : codes) {
      const auto value = static_cast<double>(code);
      const auto found = decode(item, encode_as_read(item, value));
      if (found && *found == value) continue;
      return fmt::format("the code {} of \"{}\" never occurs: {}", code, name,
                         found ? fmt::format("the nearest value is {:g}", *found)
                               : "\"sentinels\", \"lowest\" or \"highest\" exclude it");
    }
  return {};
}

std::string describe_shared_bit(const RegisterItem& item) {
  std::map<int, std::string> names;
  for (const auto& [name, bit] : item.flags)
    if (const auto [other, is_new] = names.emplace(bit, name); !is_new)
      return fmt::format("{} and {} are both bit {}", other->second, name, bit);
  return {};
}

std::optional<std::uint32_t> lower_bits(double value) {
  if (!(std::abs(value) <= static_cast<double>(kLargestCode))) return std::nullopt;
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
}

std::string meaning(const RegisterItem& item, double value) {
  for (const auto& [name, codes] : item.codes)
    if (std::ranges::any_of(codes, [&](auto code) { return static_cast<double>(code) == value; })) return name;
  if (!item.otherwise.empty()) return item.otherwise;
  const auto unknown = item.unknown_texts ? item.unknown_texts->find_text(value) : std::nullopt;
  return unknown ? fmt::format("\"{}\" (no name in codes)", plain(*unknown)) : fmt::format("{:g}", value);
}

std::vector<std::uint16_t> encode_text(const TextForm& form, std::string_view text) {
  assert(form.per_register == 1 || form.per_register == 2);
  std::string whole(text.substr(0, form.characters));
  const int padded = form.characters + form.characters % form.per_register;
  whole.resize(static_cast<std::size_t>(padded), form.padding);
  const auto byte = [&](std::size_t i) { return static_cast<std::uint16_t>(static_cast<unsigned char>(whole[i])); };
  std::vector<std::uint16_t> words;
  for (std::size_t i = 0; i < whole.size(); i += form.per_register) {
    if (i > 0) words.resize(words.size() + form.stride - 1U);
    if (form.per_register == 1) {
      words.push_back(byte(i));
      continue;
    }
    const auto high = byte(form.low_byte_first ? i + 1 : i), low = byte(form.low_byte_first ? i : i + 1);
    words.push_back(static_cast<std::uint16_t>(high << 8 | low));
  }
  return words;
}

std::string decode_text(const TextForm& form, std::span<const std::uint16_t> words) {
  std::string bytes;
  const auto add = [&](unsigned byte) {
    if (bytes.size() < form.characters) bytes += static_cast<char>(byte);
  };
  for (std::size_t i = 0; i < words.size(); i += form.stride) {
    const unsigned high = words[i] >> 8, low = words[i] & 0xFFU;
    if (form.per_register == 2) add(form.low_byte_first ? low : high);
    add(form.per_register == 2 && form.low_byte_first ? high : low);
  }
  const auto last = bytes.find_last_not_of(form.padding);
  bytes.resize(last == std::string::npos ? 0 : last + 1);
  std::ranges::transform(bytes, bytes.begin(), to_printable);
  return bytes;
}

std::vector<std::uint16_t> encode_date(const DateForm& form, const CivilTime& time) {
  std::vector<std::uint16_t> words;
  for (const auto& word : form.words) {
    if (!words.empty()) words.resize(words.size() + form.stride - 1U);
    const int high = part(form, time, word.high);
    words.push_back(static_cast<std::uint16_t>(word.low ? high << 8 | part(form, time, *word.low) : high));
  }
  return words;
}

Result<CivilTime> decode_date(const DateForm& form, std::span<const std::uint16_t> words) {
  CivilTime time;
  for (std::size_t i = 0; i < form.words.size() && i * form.stride < words.size(); ++i) {
    const auto& parts = form.words[i];
    const int word = words[i * form.stride];
    set_part(form, time, parts.high, parts.low ? word >> 8 : word);
    if (parts.low) set_part(form, time, *parts.low, word & 0xFF);
  }
  if (is_valid_time(time)) return time;
  return failure(FaultKind::out_of_range, "",
                 fmt::format("{}-{}-{} {}:{}:{} is not a valid date and time", time.year, time.month, time.day,
                             time.hour, time.minute, time.second));
}

CivilTime add_duration(const CivilTime& time, Duration by) {
  const auto of = [](int value) { return static_cast<unsigned>(value); };
  const sys_days date = year(time.year) / of(time.month) / of(time.day);
  return to_civil_time(date.time_since_epoch() + std::chrono::hours(time.hour) + std::chrono::minutes(time.minute) +
                       std::chrono::seconds(time.second) + by);
}

CivilTime to_civil_time(Duration utc) {
  const auto whole_days = std::chrono::floor<std::chrono::days>(utc);
  const std::chrono::year_month_day date{sys_days(whole_days)};
  const std::chrono::hh_mm_ss clock{std::chrono::floor<std::chrono::seconds>(utc - whole_days)};
  return {static_cast<int>(date.year()),
          static_cast<int>(static_cast<unsigned>(date.month())),
          static_cast<int>(static_cast<unsigned>(date.day())),
          static_cast<int>(clock.hours().count()),
          static_cast<int>(clock.minutes().count()),
          static_cast<int>(clock.seconds().count())};
}

}  // namespace gyrotherm::drivers
