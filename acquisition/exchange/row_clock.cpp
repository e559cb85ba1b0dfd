// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/row_clock.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>

#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/exchange/text_lines.hpp"
#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::int64_t kGpsWeek_s = 604800;
constexpr const char* kTooLate = "more than ten years after the first row";

tl::unexpected<Fault> bad_file_failure(std::string what) { return failure(FaultKind::bad_file, "", std::move(what)); }

/// Returns GPS time minus UTC (IERS Bulletin C). It increases by one second at each of these dates.
Duration leap_seconds_of_gps(Duration gps_time) {
  using std::chrono::sys_days, std::chrono::January, std::chrono::July, std::chrono::year;
  static constexpr std::array<sys_days, 18> kDays{
      sys_days(year(1981) / July / 1),    sys_days(year(1982) / July / 1),    sys_days(year(1983) / July / 1),
      sys_days(year(1985) / July / 1),    sys_days(year(1988) / January / 1), sys_days(year(1990) / January / 1),
      sys_days(year(1991) / January / 1), sys_days(year(1992) / July / 1),    sys_days(year(1993) / July / 1),
      sys_days(year(1994) / July / 1),    sys_days(year(1996) / January / 1), sys_days(year(1997) / July / 1),
      sys_days(year(1999) / January / 1), sys_days(year(2006) / January / 1), sys_days(year(2009) / January / 1),
      sys_days(year(2012) / July / 1),    sys_days(year(2015) / July / 1),    sys_days(year(2017) / January / 1)};
  std::int64_t seconds = 0;
  for (const sys_days day : kDays)
    if (gps_time - kSecond * seconds >= day.time_since_epoch()) ++seconds;
  return kSecond * seconds;
}

std::optional<CivilTime> dated_time(const ImportMap& map, std::string_view date, std::string_view clock) {
  if (map.time_form == TimeForm::civil) return parse_civil_time(date);
  auto time = parse_local_time(date, map.date_order);
  if (!time || !map.clock) return time;
  const auto of_day = parse_clock(clock);
  if (!of_day) return std::nullopt;
  time->reading += *of_day;
  return time;
}

const char* expected_date(const ImportMap& map) {
  if (map.time_form == TimeForm::civil) return "a time like \"2026-03-01T12:30:05.25Z\"";
  switch (map.date_order) {
    case DateOrder::year_first: return "a date with year, month and day in this order, like 2026/03/31 12:30:05";
    case DateOrder::day_first: return "a date with day, month and year in this order, like 31.03.2026 12:30:05";
    case DateOrder::month_first: break;
  }
  return "a date with month, day and year in this order, like 03/31/2026 12:30:05";
}

/// Returns the duration from the first text to the last one, for each notation in which both can be parsed.
std::vector<Duration> possible_spans(const OtherClocks::Clock& clock) {
  std::vector<Duration> spans;
  const auto add = [&](const auto& first, const auto& last) {
    if (first && last) spans.push_back(*last - *first);
  };
  const auto utc = [](const std::optional<CivilTime>& time) {
    return time ? std::optional(time->reading - time->zone.value_or(Duration{})) : std::nullopt;
  };
  add(utc(parse_civil_time(clock.first)), utc(parse_civil_time(clock.last)));
  for (const auto order : {DateOrder::year_first, DateOrder::day_first, DateOrder::month_first})
    add(utc(parse_local_time(clock.first, order)), utc(parse_local_time(clock.last, order)));
  return spans;
}

bool has_time_of_day(std::string_view text) { return text.find(':') != std::string_view::npos; }

}  // namespace

CountedTime RowClock::unwrap(const CountedTime& number) {
  if (!map_.wrap) return number;
  if (read_.last_number) {
    const auto half = std::chrono::duration_cast<Duration>((kSecond * map_.wrap->seconds + map_.wrap->part) / 2);
    const auto step = duration_between(*read_.last_number, number);
    if (step && *step < -half) read_.wrapped = read_.wrapped + *map_.wrap;
    if (step && *step > half && read_.wrapped.seconds + read_.wrapped.part.count() > 0)
      read_.wrapped = read_.wrapped + CountedTime{-map_.wrap->seconds, -map_.wrap->part};
  }
  read_.last_number = number;
  return number + read_.wrapped;
}

Result<void> RowClock::read_number(const CountedTime& number, std::optional<double> week, ForeignRow& row) {
  read_ = accepted_;
  auto counted = unwrap(number);
  if (week) {
    if (std::isnan(*week) || *week < 0 || *week > 1e5 || std::floor(*week) != *week)
      return bad_file_failure("not a GPS week, expected a whole number from 0 to 100000");
    counted = counted + CountedTime{static_cast<std::int64_t>(*week) * kGpsWeek_s};
  }
  if (!read_.first_number) read_.first_number = counted;
  const auto since_first = duration_between(*read_.first_number, counted);
  if (!since_first) return bad_file_failure(kTooLate);
  row.time = *since_first;
  if (!map_.since || (map_.counts_local_days && !map_.zone)) return {};
  row.utc = to_utc(*map_.since + counted);
  if (row.utc && map_.zone) *row.utc -= *map_.zone;
  if (row.utc && map_.counts_gps) *row.utc -= leap_seconds_of_gps(*row.utc);
  if (row.utc && record::is_possible_time(*row.utc)) return {};
  return bad_file_failure("a time outside 1970 to 2116: do unit and since in [time] fit?");
}

Result<void> RowClock::read_date(std::string_view date, std::string_view clock, ForeignRow& row) {
  read_ = accepted_;
  const auto time = dated_time(map_, date, clock);
  const auto shown = [&] { return plain(in_utf8(map_.clock ? fmt::format("{} {}", date, clock) : std::string(date))); };
  if (!time) return bad_file_failure(fmt::format("\"{}\", expected {}", shown(), expected_date(map_)));
  const auto zone = time->zone ? time->zone : map_.zone;
  if (!zone)
    return bad_file_failure(
        fmt::format("\"{}\" has no zone, expected one after the time, or zone = \"Z\" in [time]", shown()));
  row.utc = time->reading - *zone;
  if (!record::is_possible_time(*row.utc)) return bad_file_failure("a time outside 1970 to 2116");
  if (!read_.first_utc) read_.first_utc = *row.utc;
  row.time = *row.utc - *read_.first_utc;
  return std::chrono::abs(row.time) <= kLongestForeignTime ? Result<void>{} : bad_file_failure(kTooLate);
}

Result<void> RowClock::read_clock(std::string_view clock, ForeignRow& row) {
  constexpr Duration kHalfDay = std::chrono::hours(12), kDay = std::chrono::hours(24);
  const auto of_day = parse_clock(clock);
  if (!of_day)
    return bad_file_failure(fmt::format("\"{}\", expected a time of day like 08:30:05", plain(in_utf8(clock))));
  read_ = accepted_;
  const Duration step = *of_day - read_.last_clock.value_or(*of_day);
  if (step < -kHalfDay) read_.days += kDay;
  if (step > kHalfDay && read_.days > Duration{}) read_.days -= kDay;
  read_.last_clock = *of_day;
  if (!read_.first_clock) read_.first_clock = *of_day;
  row.time = *of_day + read_.days - *read_.first_clock;
  return row.time <= kLongestForeignTime ? Result<void>{} : bad_file_failure(kTooLate);
}

void OtherClocks::begin(std::size_t column, const std::string& name, std::string_view first) {
  constexpr std::size_t kMaxClocks = 4;
  if (clocks_.size() == kMaxClocks || !has_time_of_day(first)) return;
  Clock clock{column, name, std::string(first), std::string(first)};
  if (parse_clock(first) || !possible_spans(clock).empty()) clocks_.push_back(std::move(clock));
}

void OtherClocks::report(Findings& findings) const {
  constexpr Duration kDay = std::chrono::hours(24);
  for (const Clock& clock : clocks_) {
    auto spans = possible_spans(clock);
    const auto first = parse_clock(clock.first), last = parse_clock(clock.last);
    const bool is_time_of_day = first && last;
    if (is_time_of_day) spans = {*last < *first ? *last + kDay - *first : *last - *first};
    std::erase_if(spans, [](Duration span) { return span <= Duration{}; });
    if (spans.empty()) continue;
    findings.other_clock = clock.name;
    findings.other_spans = spans;
    findings.other_period = is_time_of_day ? kDay : Duration{};
    return;
  }
}

}  // namespace gyrotherm::exchange
