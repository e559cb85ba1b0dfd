// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/other_clocks.hpp"

#include "acquisition/exchange/local_time.hpp"

namespace gyrotherm::exchange {

namespace {

/// How much later the last text is than the first, by each way to read both.
std::vector<Duration> spans_of(const OtherClocks::Clock& clock) {
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

void OtherClocks::begin(std::size_t column, const std::string& name, std::string_view first) {
  constexpr std::size_t kMost = 4;
  if (clocks_.size() == kMost || !has_time_of_day(first)) return;
  Clock clock{column, name, std::string(first), std::string(first)};
  if (parse_clock(first) || !spans_of(clock).empty()) clocks_.push_back(std::move(clock));
}

void OtherClocks::report(Findings& findings) const {
  constexpr Duration kDay = std::chrono::hours(24);
  for (const Clock& clock : clocks_) {
    auto spans = spans_of(clock);
    const auto first = parse_clock(clock.first), last = parse_clock(clock.last);
    if (first && last) spans = {*last < *first ? *last + kDay - *first : *last - *first};
    std::erase_if(spans, [](Duration span) { return span <= Duration{}; });
    if (spans.empty()) continue;
    findings.other_clock = clock.name;
    findings.other_spans = spans;
    return;
  }
}

}  // namespace gyrotherm::exchange
