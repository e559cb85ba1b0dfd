#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>

#include "drivers/chamber/register_item.hpp"

namespace gyrotherm {

namespace {

using std::chrono::sys_days;
using std::chrono::year;

constexpr char kNotPrintable = '?';

char printable(char byte) { return byte >= 0x20 && byte < 0x7F ? byte : kNotPrintable; }

/// Weekdays count from 0, Sunday.
int weekday(const CivilTime& time) {
  return static_cast<int>(std::chrono::weekday(sys_days(year(time.year) / time.month / time.day)).c_encoding());
}

int part(const DateForm& form, const CivilTime& time, DatePart which) {
  switch (which) {
    case DatePart::year: return time.year - form.century;
    case DatePart::month: return time.month;
    case DatePart::day: return time.day;
    case DatePart::weekday: return weekday(time);
    case DatePart::hour: return time.hour;
    case DatePart::minute: return time.minute;
    case DatePart::second: return time.second;
  }
  return 0;
}

void take(const DateForm& form, CivilTime& time, DatePart which, int value) {
  switch (which) {
    case DatePart::year: time.year = value + form.century; return;
    case DatePart::month: time.month = value; return;
    case DatePart::day: time.day = value; return;
    case DatePart::weekday: return;
    case DatePart::hour: time.hour = value; return;
    case DatePart::minute: time.minute = value; return;
    case DatePart::second: time.second = value; return;
  }
}

bool is_in_the_calendar(const CivilTime& t) {
  const auto of = [](int value) { return static_cast<unsigned>(value); };
  return t.year >= 1970 && t.year < 2200 && (year(t.year) / of(t.month) / of(t.day)).ok() && t.hour < 24 &&
         t.minute < 60 && t.second < 60;
}

}  // namespace

std::vector<std::uint16_t> encode_text(const TextForm& form, std::string_view text) {
  assert(form.per_register == 1 || form.per_register == 2);
  std::string whole(text.substr(0, form.characters));
  whole.resize(static_cast<std::size_t>(form.characters + form.characters % form.per_register), form.padding);
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
  std::ranges::transform(bytes, bytes.begin(), printable);
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
    take(form, time, parts.high, parts.low ? word >> 8 : word);
    if (parts.low) take(form, time, *parts.low, word & 0xFF);
  }
  if (is_in_the_calendar(time)) return time;
  return failure(FaultKind::out_of_range, "",
                 fmt::format("{}-{}-{} {}:{}:{} is no time of any calendar", time.year, time.month, time.day, time.hour,
                             time.minute, time.second));
}

CivilTime later(const CivilTime& time, Duration by) {
  const auto of = [](int value) { return static_cast<unsigned>(value); };
  const sys_days date = year(time.year) / of(time.month) / of(time.day);
  return civil_time_of(date.time_since_epoch() + std::chrono::hours(time.hour) + std::chrono::minutes(time.minute) +
                       std::chrono::seconds(time.second) + by);
}

CivilTime civil_time_of(Duration utc) {
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

}  // namespace gyrotherm
