// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/civil_time.hpp"

#include <charconv>
#include <chrono>

#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

/// Takes what is written off the front of a text.
class Digits {
 public:
  explicit Digits(std::string_view text) : rest_(text) {}

  /// So many digits, as a number of at most `most`.
  std::optional<int> number(std::size_t digits, int most) {
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
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

constexpr int kEndOfDay = 24;

/// The time of day, where one follows; the text may end without.
std::optional<Duration> time_of_day(Digits& digits) {
  if (digits.rest().empty()) return Duration{};
  if (!digits.next_is("T ")) return std::nullopt;
  const auto hour = digits.number(2, kEndOfDay);
  if (!hour || !digits.next_is(":")) return std::nullopt;
  const auto minute = digits.number(2, 59);
  if (!minute) return std::nullopt;
  const Duration whole = std::chrono::hours(*hour) + std::chrono::minutes(*minute);
  if (*hour == kEndOfDay && *minute > 0) return std::nullopt;
  if (!digits.next_is(":")) return whole;
  const auto second = digits.number(2, 60);  // a leap second is the first of the next minute
  if (!second) return std::nullopt;
  const Duration part = digits.next_is(".,") ? digits.fraction() : Duration{};
  const Duration time = whole + std::chrono::seconds(*second) + part;
  return *hour == kEndOfDay && time > std::chrono::hours(kEndOfDay) ? std::nullopt : std::optional(time);
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
  const auto year = digits.number(4, 9999);
  if (!year || !digits.next_is("-")) return std::nullopt;
  const auto month = digits.number(2, 12);
  if (!month || !digits.next_is("-")) return std::nullopt;
  const auto day = digits.number(2, 31);
  if (!day) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  constexpr int kFirstYear = 1970, kLastYear = 2115;  // of a clock that a record can have
  if (!date.ok() || *year < kFirstYear || *year > kLastYear) return std::nullopt;
  const auto of_day = time_of_day(digits);
  if (!of_day) return std::nullopt;
  CivilTime time{.reading = std::chrono::sys_days(date).time_since_epoch() + *of_day};
  if (digits.rest().empty()) return time;
  time.zone = parse_zone(trimmed(digits.rest()));
  if (!time.zone || !record::is_possible_time(time.reading - *time.zone)) return std::nullopt;
  return time;
}

}  // namespace gyrotherm::exchange
