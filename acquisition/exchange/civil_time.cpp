// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/civil_time.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <string>

#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

/// How many digits a field has: as many as it is said to, or one at least.
enum class Width { exact, at_most };

/// Takes what is written off the front of a text.
class Digits {
 public:
  explicit Digits(std::string_view text, Width width = Width::exact) : rest_(text), width_(width) {}

  /// So many digits, as a number of at most `most`.
  std::optional<int> number(std::size_t digits, int most) {
    if (width_ == Width::at_most) {
      const std::size_t there = std::min(rest_.find_first_not_of("0123456789"), rest_.size());
      if (there == 0 || there > digits) return std::nullopt;
      digits = there;
    }
    if (rest_.size() < digits) return std::nullopt;
    int number = 0;
    const char* end = rest_.data() + digits;
    if (rest_.front() == '-' || rest_.front() == '+') return std::nullopt;
    if (const auto read = std::from_chars(rest_.data(), end, number); read.ptr != end || number > most)
      return std::nullopt;
    rest_.remove_prefix(digits);
    return number;
  }
  /// One of the characters, if it is next.
  bool next_is(std::string_view characters) {
    if (rest_.empty() || characters.find(rest_.front()) == std::string_view::npos) return false;
    rest_.remove_prefix(1);
    return true;
  }
  /// The part of a second that the digits behind its point are; those beyond nanoseconds do not count.
  Duration fraction() {
    Duration::rep sum = 0, unit = std::chrono::nanoseconds(kSecond).count();
    while (!rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9') {
      unit /= 10;
      sum += unit * (rest_.front() - '0');
      rest_.remove_prefix(1);
    }
    return Duration(sum);
  }
  void pass_blanks() { rest_ = trimmed(rest_); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  Width width_;
};

constexpr int kEndOfDay = 24;

/// Hours and minutes, with seconds where they are said, and of these a fraction behind one of the marks.
std::optional<Duration> clock_time(Digits& digits, int most_hours, std::string_view marks) {
  const auto hour = digits.number(2, most_hours);
  if (!hour || !digits.next_is(":")) return std::nullopt;
  const auto minute = digits.number(2, 59);
  if (!minute) return std::nullopt;
  const Duration whole = std::chrono::hours(*hour) + std::chrono::minutes(*minute);
  if (!digits.next_is(":")) return whole;
  const auto second = digits.number(2, 60);  // a leap second is the first of the next minute
  if (!second) return std::nullopt;
  return whole + std::chrono::seconds(*second) + (digits.next_is(marks) ? digits.fraction() : Duration{});
}

/// The time of day, where one follows; the text may end without. It ends at 24:00 and not later.
std::optional<Duration> time_of_day(Digits& digits) {
  if (digits.rest().empty()) return Duration{};
  if (!digits.next_is("T ")) return std::nullopt;
  const bool is_its_end = digits.rest().starts_with("24");
  const auto time = clock_time(digits, kEndOfDay, ".,");
  return is_its_end && time && *time > std::chrono::hours(kEndOfDay) ? std::nullopt : time;
}

struct Date {
  int year{}, month{}, day{};

  [[nodiscard]] std::chrono::year_month_day gregorian() const {
    return {std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
            std::chrono::day(static_cast<unsigned>(day))};
  }
};

/// "2026-03-01", which may be none that there is.
std::optional<Date> date_of(Digits& digits) {
  const auto year = digits.number(4, 9999);
  if (!year || !digits.next_is("-")) return std::nullopt;
  const auto month = digits.number(2, 12);
  if (!month || !digits.next_is("-")) return std::nullopt;
  const auto day = digits.number(2, 31);
  return day ? std::optional(Date{*year, *month, *day}) : std::nullopt;
}

/// "+1", "-6:00", "-0330", "UTC", "GMT", "Z"; UTC where nothing stands.
std::optional<Duration> loose_zone(std::string_view text) {
  for (const std::string_view utc : {"", "UTC", "GMT", "Z", "utc", "gmt", "z"})
    if (text == utc) return Duration{};
  if (!text.starts_with('-') && !text.starts_with('+')) return std::nullopt;
  std::string zone(text);
  const std::size_t digits = std::min(zone.find(':'), zone.size()) - 1;
  if (digits % 2 == 1) zone.insert(1, "0");
  return parse_zone(zone);
}

/// Days since 1970-01-01, of a date of the Julian calendar; nothing if it has no such date.
std::optional<std::int64_t> days_of_julian(const Date& date) {
  const auto& [year, month, day] = date;
  constexpr std::array<int, 12> kDays{31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool is_29_february = month == 2 && day == 29;
  if (month < 1 || day < 1 || day > kDays[static_cast<std::size_t>(month - 1)] || (is_29_february && year % 4 != 0))
    return std::nullopt;
  // Years begin in March, so that the leap day is the last: 153 days make five months of them.
  constexpr int kDaysOfFourYears = 1461, kDaysBefore1970 = 719470;
  const int since_march = (month + 9) % 12, years = month > 2 ? year : year - 1;
  const int of_years = kDaysOfFourYears * (years + 4) / 4 - kDaysOfFourYears;
  return of_years + (153 * since_march + 2) / 5 + day - 1 - kDaysBefore1970;
}

std::optional<std::int64_t> days_since_1970(const Date& said, EarlyDays early) {
  const auto date = said.gregorian();
  constexpr std::chrono::year_month_day kReform{std::chrono::year(1582), std::chrono::October, std::chrono::day(15)};
  if (early == EarlyDays::julian && date < kReform) return days_of_julian(said);
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

}  // namespace

std::optional<Duration> parse_zone(std::string_view text) {
  if (text == "Z" || text == "z") return Duration{};
  Digits digits(text);
  const bool behind = text.starts_with('-');
  if (!digits.next_is("+-")) return std::nullopt;
  const auto hours = digits.number(2, 23);
  if (!hours) return std::nullopt;
  (void)digits.next_is(":");
  const auto minutes = digits.rest().empty() ? std::optional(0) : digits.number(2, 59);
  if (!minutes || !digits.rest().empty()) return std::nullopt;
  const Duration ahead = std::chrono::hours(*hours) + std::chrono::minutes(*minutes);
  return behind ? -ahead : ahead;
}

std::optional<CivilTime> parse_civil_time(std::string_view text) {
  Digits digits(text);
  const auto said = date_of(digits);
  if (!said) return std::nullopt;
  const auto date = said->gregorian();
  constexpr int kFirstYear = 1970, kLastYear = 2115;  // of a clock that a record can have
  if (!date.ok() || said->year < kFirstYear || said->year > kLastYear) return std::nullopt;
  const auto of_day = time_of_day(digits);
  if (!of_day) return std::nullopt;
  CivilTime time{.reading = std::chrono::sys_days(date).time_since_epoch() + *of_day};
  if (digits.rest().empty()) return time;
  time.zone = parse_zone(trimmed(digits.rest()));
  if (!time.zone || !record::is_possible_time(time.reading - *time.zone)) return std::nullopt;
  return time;
}

std::optional<CountedTime> parse_reference_time(std::string_view text, EarlyDays early) {
  Digits digits(trimmed(text), Width::at_most);
  const auto date = date_of(digits);
  if (!date) return std::nullopt;
  const auto days = days_since_1970(*date, early);
  if (!days) return std::nullopt;
  const bool has_time_behind = digits.next_is("Tt");
  digits.pass_blanks();
  const bool has_time = has_time_behind || digits.rest().find_first_of("0123456789") == 0;
  const auto of_day = has_time ? clock_time(digits, kEndOfDay - 1, ".") : std::optional(Duration{});
  const auto zone = loose_zone(trimmed(digits.rest()));
  if (!of_day || !zone) return std::nullopt;
  constexpr std::int64_t kSecondsOfDay = 86400;
  return CountedTime{*days * kSecondsOfDay} + counted_time((*of_day - *zone).count(), Duration(1));
}

}  // namespace gyrotherm::exchange
