// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/foreign_time.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "acquisition/exchange/column_names.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

// Counted times.

constexpr std::int64_t kLongest_s = std::numeric_limits<std::int64_t>::max() / 4;  // the sum of two must fit

/// Returns the same time with `part` between zero and one second.
CountedTime normalise(std::int64_t seconds, Duration part) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(part);
  return {seconds + whole.count(), part - whole};
}

/// Returns a number of units and a fraction of a unit as a time.
CountedTime make_counted_time(std::int64_t whole, double fraction, Duration unit) {
  const Duration part = from_seconds(fraction * to_seconds(unit));
  if (unit < kSecond) {
    const std::int64_t in_a_second = kSecond / unit;
    return normalise(whole / in_a_second, unit * (whole % in_a_second) + part);
  }
  const std::int64_t seconds = unit / kSecond, longest = kLongest_s / seconds;
  return normalise(std::clamp(whole, -longest, longest) * seconds, part);
}

struct Decimal {
  std::int64_t whole{};
  double fraction{};  ///< same sign as the integer
};

std::optional<std::uint64_t> digits_in(std::string_view text) {
  std::uint64_t number = 0;
  if (text.empty()) return number;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// Parses a decimal number. Returns nothing if the number has an exponent or its integer part exceeds 64 bits.
std::optional<Decimal> decimal_in(std::string_view text) {
  constexpr std::size_t kMaxBehindPoint = 18;
  static constexpr std::array<double, kMaxBehindPoint + 1> kPowers{
      1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18};
  const bool is_negative = text.starts_with('-');
  if (is_negative || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t point = std::min(text.find('.'), text.size());
  const auto before = text.substr(0, point), behind = text.substr(std::min(point + 1, text.size()));
  const auto counted = behind.substr(0, kMaxBehindPoint), rest = behind.substr(counted.size());
  if (before.size() + behind.size() == 0 || rest.find_first_not_of("0123456789") != std::string_view::npos)
    return std::nullopt;
  const auto whole = digits_in(before), part = digits_in(counted);
  if (!whole || !part || *whole > std::numeric_limits<std::int64_t>::max()) return std::nullopt;
  const Decimal number{static_cast<std::int64_t>(*whole), static_cast<double>(*part) / kPowers[counted.size()]};
  return is_negative ? Decimal{-number.whole, -number.fraction} : number;
}

// Calendar times.

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Returns true for ASCII letters and for the bytes of other letters.
bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) >= 0x80;
}

int parse_digits(std::string_view digits) {
  constexpr int kNone = -1;
  int number = kNone;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return read.ec == std::errc() && read.ptr == digits.data() + digits.size() ? number : kNone;
}

/// The number of digits of a field: exactly the given number, or at most the given number.
enum class Width { exact, at_most };

/// Parses from the front of a text and removes the parsed part.
class FrontParser {
 public:
  explicit FrontParser(std::string_view text, Width width = Width::exact) : rest_(text), width_(width) {}

  /// Removes and returns a number with the given number of digits and a value of at most `most`.
  std::optional<int> take_number(std::size_t digits, int most) {
    const std::size_t there = std::min(rest_.find_first_not_of("0123456789"), rest_.size());
    if (width_ == Width::at_most && there > digits) return std::nullopt;
    if (width_ == Width::at_most) digits = there;
    if (digits == 0 || there < digits) return std::nullopt;
    const int number = parse_digits(take(digits));
    return number <= most ? std::optional(number) : std::nullopt;
  }
  std::string_view take_digits() {
    const auto end = std::ranges::find_if_not(rest_, is_digit);
    return take(static_cast<std::size_t>(end - rest_.begin()));
  }
  std::string_view take_word() {
    const auto end = std::ranges::find_if_not(rest_, is_letter);
    return take(static_cast<std::size_t>(end - rest_.begin()));
  }
  /// Removes the decimals of a second. Ignores digits below nanoseconds.
  Duration take_fraction() {
    Duration::rep sum = 0, unit = std::chrono::nanoseconds(kSecond).count();
    for (const char digit : take_digits()) sum += (unit /= 10) * (digit - '0');
    return Duration(sum);
  }
  /// Removes the next character if it is one of `characters`.
  bool take_if(std::string_view characters) {
    if (rest_.empty() || characters.find(rest_.front()) == std::string_view::npos) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void skip_blanks() { rest_ = trimmed(rest_); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view take(std::size_t count) {
    const auto taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  std::string_view rest_;
  Width width_;
};

struct Date {
  int year{}, month{}, day{};

  [[nodiscard]] std::chrono::year_month_day to_gregorian() const {
    return {std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
            std::chrono::day(static_cast<unsigned>(day))};
  }
};

/// Returns the time of a date. Returns nothing if the date does not exist or is outside the range of a record. The
/// types of the library have only 8 bits for a month and a day, so their ranges are checked here.
std::optional<CivilTime> make_civil_time(const Date& given, Duration of_day) {
  constexpr int kFirstYear = 1970, kLastYear = 2115, kMonths = 12, kMaxDays = 31;
  if (given.year < kFirstYear || given.year > kLastYear || given.month < 1 || given.month > kMonths || given.day < 1 ||
      given.day > kMaxDays)
    return std::nullopt;
  const auto date = given.to_gregorian();
  if (!date.ok()) return std::nullopt;
  return CivilTime{.reading = std::chrono::sys_days(date).time_since_epoch() + of_day};
}

// Times in ISO 8601 and UDUNITS.

constexpr int kEndOfDay = 24;

/// Removes hours and minutes, and optional seconds with a fraction after one of the marks.
std::optional<Duration> take_clock_time(FrontParser& front, int most_hours, std::string_view marks) {
  const auto hour = front.take_number(2, most_hours);
  if (!hour || !front.take_if(":")) return std::nullopt;
  const auto minute = front.take_number(2, 59);
  if (!minute) return std::nullopt;
  const Duration whole = std::chrono::hours(*hour) + std::chrono::minutes(*minute);
  if (!front.take_if(":")) return whole;
  const auto second = front.take_number(2, 60);  // 60 is a leap second
  if (!second) return std::nullopt;
  return whole + std::chrono::seconds(*second) + (front.take_if(marks) ? front.take_fraction() : Duration{});
}

/// Removes the time of day, at most 24:00. It may be missing at the end of the text.
std::optional<Duration> take_time_of_day(FrontParser& front) {
  if (front.rest().empty()) return Duration{};
  if (!front.take_if("T ")) return std::nullopt;
  const bool is_end_of_day = front.rest().starts_with("24");
  const auto time = take_clock_time(front, kEndOfDay, ".,");
  return is_end_of_day && time && *time > std::chrono::hours(kEndOfDay) ? std::nullopt : time;
}

/// Removes "2026-03-01". The date may not exist.
std::optional<Date> take_date(FrontParser& front) {
  const auto year = front.take_number(4, 9999);
  if (!year || !front.take_if("-")) return std::nullopt;
  const auto month = front.take_number(2, 12);
  if (!month || !front.take_if("-")) return std::nullopt;
  const auto day = front.take_number(2, 31);
  return day ? std::optional(Date{*year, *month, *day}) : std::nullopt;
}

/// Parses "+1", "-6:00", "-0330", "UTC", "GMT", "Z". An empty text is UTC.
std::optional<Duration> parse_loose_zone(std::string_view text) {
  for (const std::string_view utc : {"", "UTC", "GMT", "Z", "utc", "gmt", "z"})
    if (text == utc) return Duration{};
  if (!text.starts_with('-') && !text.starts_with('+')) return std::nullopt;
  std::string zone(text);
  const std::size_t digits = std::min(zone.find(':'), zone.size()) - 1;
  if (digits % 2 == 1) zone.insert(1, "0");
  return parse_zone(zone);
}

/// Returns the days since 1970-01-01 of a Julian date, or nothing if the date does not exist.
std::optional<std::int64_t> julian_days(const Date& date) {
  const auto& [year, month, day] = date;
  constexpr std::array<int, 12> kDays{31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool is_29_february = month == 2 && day == 29;
  if (month < 1 || day < 1 || day > kDays[static_cast<std::size_t>(month - 1)] || (is_29_february && year % 4 != 0))
    return std::nullopt;
  // Years are counted from March. The leap day is then the last day of the year. Five months from March have 153 days.
  constexpr int kDaysOfFourYears = 1461, kDaysBefore1970 = 719470;
  const int since_march = (month + 9) % 12, years = month > 2 ? year : year - 1;
  const int of_years = kDaysOfFourYears * (years + 4) / 4 - kDaysOfFourYears;
  return of_years + (153 * since_march + 2) / 5 + day - 1 - kDaysBefore1970;
}

std::optional<std::int64_t> days_since_1970(const Date& given, EarlyDays early) {
  const auto date = given.to_gregorian();
  constexpr std::chrono::year_month_day kReform{std::chrono::year(1582), std::chrono::October, std::chrono::day(15)};
  if (early == EarlyDays::julian && date < kReform) return julian_days(given);
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

// Times in local notations.

/// Returns the month with whose name a word begins; 0 if there is none. The names in the five languages do not
/// conflict.
int parse_month_name(std::string_view word) {
  static constexpr std::array<std::pair<std::string_view, int>, 38> kNames{
      {{"jan", 1},  {"jän", 1},  {"ene", 1},  {"gen", 1},  {"feb", 2},  {"fev", 2},  {"fév", 2},  {"mar", 3},
       {"mär", 3},  {"mrz", 3},  {"mae", 3},  {"apr", 4},  {"avr", 4},  {"abr", 4},  {"may", 5},  {"mai", 5},
       {"mag", 5},  {"juin", 6}, {"jun", 6},  {"giu", 6},  {"juil", 7}, {"jul", 7},  {"lug", 7},  {"aug", 8},
       {"aoû", 8},  {"aou", 8},  {"ago", 8},  {"sep", 9},  {"set", 9},  {"oct", 10}, {"okt", 10}, {"ott", 10},
       {"nov", 11}, {"dec", 12}, {"dez", 12}, {"déc", 12}, {"dic", 12}, {"maj", 5}}};
  const auto lower = in_lower_case(word);
  for (const auto& [name, month] : kNames)
    if (lower.starts_with(name)) return month;
  return 0;
}

bool is_weekday(std::string_view word) {
  const auto lower = in_lower_case(word);
  return std::ranges::any_of(
             std::array<std::string_view, 28>{"mon", "tue", "wed", "thu", "fri", "sat", "sun", "mo",  "di",  "mi",
                                              "do",  "fr",  "sa",  "so",  "lun", "mer", "jeu", "ven", "sam", "dim",
                                              "mié", "jue", "vie", "sáb", "dom", "gio", "sab", "tu"},
             [&](std::string_view day) { return lower == day; }) ||
         lower.ends_with("day") || lower.ends_with("tag");
}

/// Removes AM or PM, with or without points. Returns 'a', 'p', or 0 if there is neither.
char take_half_of_day(FrontParser& front) {
  FrontParser ahead = front;
  ahead.skip_blanks();
  const auto lower = in_lower_case(ahead.rest().substr(0, 4));
  for (const std::string_view word : {"a.m.", "p.m.", "am", "pm"}) {
    const bool is_word =
        lower.starts_with(word) && (lower.size() == word.size() || word.size() == 4 || !is_letter(lower[word.size()]));
    if (!is_word) continue;
    for (std::size_t i = 0; i < word.size(); ++i) (void)ahead.take_if("aApPmM.");
    front = ahead;
    return word.front();
  }
  return 0;
}

std::optional<Duration> make_time_of_day(int hour, int minute, int second, Duration part, char half) {
  constexpr int kHoursPerHalfDay = 12;
  if (half != 0 && (hour < 1 || hour > kHoursPerHalfDay)) return std::nullopt;
  if (half == 'a') hour %= kHoursPerHalfDay;
  if (half == 'p') hour = hour % kHoursPerHalfDay + kHoursPerHalfDay;
  const Duration time = std::chrono::hours(hour) + std::chrono::minutes(minute) + std::chrono::seconds(second) + part;
  const bool is_one = hour >= 0 && minute >= 0 && second >= 0 && minute < 60 && second <= 60;
  return is_one && time <= std::chrono::hours(24) ? std::optional(time) : std::nullopt;
}

/// Parses the digits "hhmm" or "hhmmss", and removes a fraction of a second from the front of the text after them.
std::optional<Duration> take_compact_clock(std::string_view digits, FrontParser& front) {
  if (digits.size() != 4 && digits.size() != 6) return std::nullopt;
  const int second = digits.size() == 6 ? parse_digits(digits.substr(4)) : 0;
  const Duration part = front.take_if(".,") ? front.take_fraction() : Duration{};
  return make_time_of_day(parse_digits(digits.substr(0, 2)), parse_digits(digits.substr(2, 2)), second, part, 0);
}

/// Removes a time of day from the front.
std::optional<Duration> take_clock(FrontParser& front) {
  char half = take_half_of_day(front);
  front.skip_blanks();
  const auto first = front.take_digits();
  if (first.size() > 2) return take_compact_clock(first, front);
  const bool has_points = front.rest().starts_with('.');  // Finnish and some loggers
  if (first.empty() || !front.take_if(has_points ? "." : ":hH")) return std::nullopt;
  const auto minute = front.take_digits();
  if (minute.size() != 2) return std::nullopt;
  int second = 0;
  Duration part{};
  if (front.take_if(has_points ? "." : ":mM'")) {
    const auto seconds = front.take_digits();
    if (seconds.size() != 2) return std::nullopt;
    second = parse_digits(seconds);
    if (front.take_if(has_points ? ",." : ".,:")) part = front.take_fraction();
  }
  if (half == 0) half = take_half_of_day(front);
  return make_time_of_day(parse_digits(first), parse_digits(minute), second, part, half);
}

int expand_year(std::string_view digits) {
  constexpr int kCentury = 100, kFirstYearOf1900s = 70, kNone = -1;
  const int number = parse_digits(digits);
  if (digits.size() == 4) return number;
  if (digits.size() != 2) return kNone;
  return number + (number < kFirstYearOf1900s ? 2000 : 2000 - kCentury);
}

/// Builds a date from three parts. The first or the second may be the name of a month.
std::optional<Date> make_date(const std::array<std::string_view, 3>& parts, DateOrder order) {
  for (std::size_t i = 0; i < 2; ++i) {
    if (parts[i].empty() || is_digit(parts[i].front())) continue;
    const auto& other = parts[1 - i];
    const bool year_is_last = other.size() <= 2;
    return Date{expand_year(year_is_last ? parts[2] : other), parse_month_name(parts[i]),
                parse_digits(year_is_last ? other : parts[2])};
  }
  if (parts[0].size() == 4 || order == DateOrder::year_first)
    return order == DateOrder::year_first
               ? std::optional(Date{expand_year(parts[0]), parse_digits(parts[1]), parse_digits(parts[2])})
               : std::nullopt;
  const bool day_first = order == DateOrder::day_first;
  if (parts[0].size() > 2 || parts[1].size() > 2) return std::nullopt;
  return Date{expand_year(parts[2]), parse_digits(parts[day_first ? 1 : 0]), parse_digits(parts[day_first ? 0 : 1])};
}

/// Removes "01.03.2026", "3/1/26", "1-Mar-2026", "Mar 1, 2026" or "1. März 2026" from the front.
std::optional<Date> take_day(FrontParser& front, DateOrder order) {
  std::array<std::string_view, 3> parts;
  char separator = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    parts[i] = front.take_digits();
    if (parts[i].empty()) parts[i] = front.take_word();
    if (parts[i].empty()) return std::nullopt;
    if (i == 0 && parts[0].size() >= 8 && is_digit(parts[0].front())) return std::nullopt;  // compact
    if (i == 2) break;
    const char next = front.rest().empty() ? ' ' : front.rest().front();
    const bool has_word = !is_digit(parts[0].front()) || (i == 1 && !is_digit(parts[1].front()));
    if (!front.take_if("./-, ")) return std::nullopt;
    if (i == 1 && next != separator && !has_word) return std::nullopt;
    separator = next;
    front.skip_blanks();
    if (!is_digit(parts[i].front())) (void)front.take_if("./-,");
    front.skip_blanks();
  }
  return make_date(parts, order);
}

/// Removes "20260301", "20260301T080010", "20260301 080010" or "20260301080010".
std::optional<CivilTime> take_compact_time(FrontParser& front) {
  constexpr std::size_t kDateDigits = 8;
  const auto digits = front.take_digits();
  if (digits.size() != kDateDigits && digits.size() != kDateDigits + 4 && digits.size() != kDateDigits + 6)
    return std::nullopt;
  const Date day{parse_digits(digits.substr(0, 4)), parse_digits(digits.substr(4, 2)),
                 parse_digits(digits.substr(6, 2))};
  if (digits.size() > kDateDigits) {
    const auto of_day = take_compact_clock(digits.substr(kDateDigits), front);
    return of_day ? make_civil_time(day, *of_day) : std::nullopt;
  }
  if (front.rest().empty()) return make_civil_time(day, {});
  if (!front.take_if("Tt_- ")) return std::nullopt;
  const auto of_day = take_clock(front);
  return of_day ? make_civil_time(day, *of_day) : std::nullopt;
}

/// Removes the zone after a time if there is one. Returns false if another text follows the time.
bool take_zone(FrontParser& front, CivilTime& time) {
  front.skip_blanks();
  if (front.rest().empty()) return true;
  for (const std::string_view utc : {"UTC", "GMT", "utc", "gmt"})
    if (front.rest() == utc) {
      time.zone = Duration{};
      return true;
    }
  time.zone = parse_zone(front.rest());
  return time.zone.has_value();
}

/// Removes "Mar  1 08:00:10 2026", the C notation after the day of the week.
std::optional<CivilTime> take_c_time(FrontParser front) {
  const int month = parse_month_name(front.take_word());
  front.skip_blanks();
  const int day = parse_digits(front.take_digits());
  front.skip_blanks();
  const auto of_day = take_clock(front);
  front.skip_blanks();
  const auto year = front.take_digits();
  if (month == 0 || !of_day || year.size() != 4 || !front.rest().empty()) return std::nullopt;
  return make_civil_time({parse_digits(year), month, day}, *of_day);
}

std::optional<CivilTime> parse_dated(FrontParser front, DateOrder order) {
  if (const auto time = take_c_time(front)) return time;
  FrontParser compact = front;
  if (auto time = take_compact_time(compact); time && take_zone(compact, *time)) return time;
  const auto day = take_day(front, order);
  if (!day) return std::nullopt;
  (void)front.take_if(".");  // after a Hungarian day
  front.skip_blanks();
  if (front.rest().empty()) return make_civil_time(*day, {});
  (void)front.take_if("Tt,_-");
  front.skip_blanks();
  const auto of_day = take_clock(front);
  if (!of_day) return std::nullopt;
  auto time = make_civil_time(*day, *of_day);
  return time && take_zone(front, *time) ? time : std::nullopt;
}

}  // namespace

CountedTime counted_time(std::int64_t number, Duration unit) { return make_counted_time(number, 0, unit); }

CountedTime counted_time(double number, Duration unit) {
  constexpr double kInt64Limit = 0x1p63;
  const double whole = std::floor(number);
  if (!(std::abs(whole) < kInt64Limit)) return {number < 0 ? -kLongest_s : kLongest_s};
  return make_counted_time(static_cast<std::int64_t>(whole), number - whole, unit);
}

std::optional<CountedTime> parse_counted_time(std::string_view text, Duration unit) {
  if (const auto plain = decimal_in(text)) return make_counted_time(plain->whole, plain->fraction, unit);
  const auto number = record::number_in(text);
  return number ? std::optional(counted_time(*number, unit)) : std::nullopt;
}

std::optional<Duration> duration_between(const CountedTime& first, const CountedTime& second) {
  const std::int64_t seconds = second.seconds - first.seconds;
  if (std::abs(seconds) > kLongestForeignTime / kSecond) return std::nullopt;
  const Duration time = kSecond * seconds + (second.part - first.part);
  return std::chrono::abs(time) <= kLongestForeignTime ? std::optional(time) : std::nullopt;
}

std::optional<Duration> to_utc(const CountedTime& since_1970) {
  constexpr std::int64_t kBeyond_s = std::int64_t{1} << 33;
  if (since_1970.seconds < 0 || since_1970.seconds >= kBeyond_s) return std::nullopt;
  const Duration utc = kSecond * since_1970.seconds + since_1970.part;
  return record::is_possible_time(utc) ? std::optional(utc) : std::nullopt;
}

CountedTime operator+(const CountedTime& a, const CountedTime& b) {
  return normalise(a.seconds + b.seconds, a.part + b.part);
}

std::optional<Duration> parse_zone(std::string_view text) {
  if (text == "Z" || text == "z") return Duration{};
  FrontParser front(text);
  const bool behind = text.starts_with('-');
  if (!front.take_if("+-")) return std::nullopt;
  const auto hours = front.take_number(2, 23);
  if (!hours) return std::nullopt;
  (void)front.take_if(":");
  const auto minutes = front.rest().empty() ? std::optional(0) : front.take_number(2, 59);
  if (!minutes || !front.rest().empty()) return std::nullopt;
  const Duration ahead = std::chrono::hours(*hours) + std::chrono::minutes(*minutes);
  return behind ? -ahead : ahead;
}

std::optional<CivilTime> parse_civil_time(std::string_view text) {
  FrontParser front(text);
  const auto date = take_date(front);
  if (!date) return std::nullopt;
  const auto of_day = take_time_of_day(front);
  if (!of_day) return std::nullopt;
  auto time = make_civil_time(*date, *of_day);
  if (!time || front.rest().empty()) return time;
  time->zone = parse_zone(trimmed(front.rest()));
  if (!time->zone || !record::is_possible_time(time->reading - *time->zone)) return std::nullopt;
  return time;
}

std::optional<CountedTime> parse_reference_time(std::string_view text, EarlyDays early) {
  FrontParser front(trimmed(text), Width::at_most);
  const auto date = take_date(front);
  if (!date) return std::nullopt;
  const auto days = days_since_1970(*date, early);
  if (!days) return std::nullopt;
  const bool has_time_behind = front.take_if("Tt");
  front.skip_blanks();
  const bool has_time = has_time_behind || front.rest().find_first_of("0123456789") == 0;
  const auto of_day = has_time ? take_clock_time(front, kEndOfDay - 1, ".") : std::optional(Duration{});
  const auto zone = parse_loose_zone(trimmed(front.rest()));
  if (!of_day || !zone) return std::nullopt;
  constexpr std::int64_t kSecondsOfDay = 86400;
  return CountedTime{*days * kSecondsOfDay} + counted_time((*of_day - *zone).count(), Duration(1));
}

std::optional<CivilTime> parse_local_time(std::string_view text, DateOrder order) {
  FrontParser front(trimmed(text));
  FrontParser behind_weekday = front;
  if (is_weekday(behind_weekday.take_word())) {
    (void)behind_weekday.take_if(".");
    (void)behind_weekday.take_if(",");
    behind_weekday.skip_blanks();
    front = behind_weekday;
  }
  const auto time = parse_dated(front, order);
  return time && record::is_possible_time(time->reading - time->zone.value_or(Duration{})) ? time : std::nullopt;
}

std::optional<Duration> parse_clock(std::string_view text) {
  FrontParser front(trimmed(text));
  const auto time = take_clock(front);
  front.skip_blanks();
  return front.rest().empty() ? time : std::nullopt;
}

bool looks_like_time(std::string_view text) {
  const auto digits = std::ranges::count_if(text, is_digit);
  const bool has_exponent = text.find_first_of("eE") != std::string_view::npos;
  for (const char mark : {':', '/', '-', '.'}) {
    const bool may_be_number = has_exponent && (mark == '-' || mark == '.');
    if (std::ranges::count(text, mark) >= 2 && digits >= 4 && !may_be_number) return true;
  }
  FrontParser front(trimmed(text));
  while (!front.rest().empty()) {
    const auto word = front.take_word();
    if (word.size() >= 3 && parse_month_name(word) != 0 && digits >= 2) return true;
    if (word.empty()) (void)front.take_if(front.rest().substr(0, 1));
  }
  return false;
}

}  // namespace gyrotherm::exchange
