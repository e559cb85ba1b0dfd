// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/time_guess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>

#include "acquisition/exchange/column_names.hpp"
#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/exchange/grouping.hpp"
#include "acquisition/exchange/row_order.hpp"
#include "acquisition/record/csv.hpp"
#include "core/clock.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr double kDay_s = 86400;

/// Converts seconds to a duration. A magnitude of more than a hundred years becomes a hundred years.
Duration to_limited_duration(double time_s) {
  constexpr double kLongest_s = to_seconds(std::chrono::years(100));
  return from_seconds(std::clamp(time_s, -kLongest_s, kLongest_s));
}

double unit_seconds(std::string_view unit) {
  if (unit == "ns") return 1e-9;
  if (unit == "us") return 1e-6;
  if (unit == "ms") return 1e-3;
  if (unit == "min") return 60;
  if (unit == "h") return 3600;
  const bool is_day = unit == "d" || unit == "excel" || unit == "excel-1904" || unit == "matlab";
  return is_day ? kDay_s : 1;
}

bool is_unit_of_time(std::string_view unit) {
  return unit == "s" || unit == "ms" || unit == "us" || unit == "ns" || unit == "min" || unit == "h" || unit == "d";
}

/// Returns the median of the positive steps; 0 if there are none.
double usual_positive_step(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i)
    if (times[i] > times[i - 1]) steps.push_back(times[i] - times[i - 1]);
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + std::ssize(steps) / 2;
  std::ranges::nth_element(steps, middle);
  return *middle;
}

/// Properties of a series of times in seconds.
struct Course {
  double step_s{};        ///< median of positive steps
  std::size_t repeats{};  ///< rows with an unchanged time
  std::size_t back{};     ///< rows with an earlier time
  double first_back_s{};
  bool all_steps_back_equal{};  ///< steps backwards are about equal
};

Course measure_course(const std::vector<double>& times_s) {
  Course course{.step_s = usual_positive_step(times_s)};
  double least = 0, greatest = 0;
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    if (times_s[i] == times_s[i - 1]) ++course.repeats;
    if (times_s[i] >= times_s[i - 1]) continue;
    const double back = times_s[i - 1] - times_s[i];
    if (course.back++ == 0) course.first_back_s = least = greatest = back;
    least = std::min(least, back);
    greatest = std::max(greatest, back);
  }
  course.all_steps_back_equal = greatest - least <= 0.01 * greatest;
  return course;
}

/// Returns the number of rows that must be left out to put the times in order.
std::size_t count_left_out(const std::vector<double>& times_s) {
  ImportMap map;
  map.units = {{.axes = {record::AxisInfo{.kind = record::GyroKind::rate}}}};
  map.out_of_order = OutOfOrder::skip;
  map.every = kSecond;
  RowOrder order(map, [](const ForeignRow&) { return Result<void>(); });
  for (const double time : times_s) (void)order.push({.time = to_limited_duration(time - times_s.front())});
  (void)order.finish();
  return order.skipped_rows();
}

/// Returns the power of two at which a counter restarts; nothing if it does not, or only after ten years. `unit_s` is
/// its unit.
std::optional<double> find_wrap(const Course& course, double unit_s) {
  if (course.back == 0 || !course.all_steps_back_equal) return std::nullopt;
  for (const int bits : {16, 24, 31, 32}) {
    const double most = std::ldexp(1, bits) * unit_s;
    if (most > to_seconds(kLongestForeignTime)) break;
    if (course.first_back_s <= most && course.first_back_s > most - 3 * std::max(course.step_s, unit_s))
      return std::ldexp(1, bits);
  }
  return std::nullopt;
}

/// Returns the map lines that a series of times requires. `unit_s` is the unit of a counter, or 0 if the times are not
/// counted.
std::string course_lines(const std::vector<double>& times_s, double unit_s) {
  constexpr double kFastestKept_s = 0.5, kMaxLeftOut = 0.02;
  const Course course = measure_course(times_s);
  std::string text;
  if (const auto wrap = unit_s > 0 ? find_wrap(course, unit_s) : std::nullopt) {
    text += fmt::format("wrap = {:.0f}        # the counter restarts at this value\n", *wrap);
  } else if (course.back > 0) {
    const auto left_out = count_left_out(times_s);
    const bool is_few =
        static_cast<double>(left_out) <= std::max(2.0, kMaxLeftOut * static_cast<double>(times_s.size()));
    text += is_few ? "out_of_order = \"skip\"        # rows whose time goes back are left out\n"
                   : fmt::format(
                         "out_of_order = \"continue\"        # the time goes back {:.6g} s: rows continue after the "
                         "row before, as if the clock had been set\n",
                         course.first_back_s);
  }
  if (course.repeats > 0) {
    const double every = std::max(course.step_s, kFastestKept_s);
    return text + fmt::format("every = \"{}\"        # several rows have the same time: they are combined\n",
                              every >= 1 ? fmt::format("{:.0f} s", every) : "1 s");
  }
  if (course.step_s > 0 && course.step_s < kFastestKept_s)
    text += fmt::format("every = \"1 s\"        # rows are {:.3g} s apart: means over one second\n", course.step_s);
  return text;
}

bool is_increasing(const std::vector<double>& times) {
  const double step = usual_positive_step(times);
  if (times.size() < 2) return true;
  const auto forward = std::ranges::adjacent_find(times, std::less<>()) != times.end();
  std::size_t distinct = 1;
  for (std::size_t i = 1; i < times.size(); ++i) distinct += times[i] != times[i - 1] ? 1 : 0;
  constexpr std::size_t kMaxOfOneTime = 1000;
  return step > 0 && forward && distinct * kMaxOfOneTime >= times.size();
}

/// The calendar times of a column.
struct DatedColumn {
  std::vector<double> times_s{};
  bool has_zone = true, has_time_of_day = false;
};
using ParseDate = std::function<std::optional<CivilTime>(const std::string&)>;

std::optional<DatedColumn> parse_dates(const TableSample& sample, std::size_t column, const ParseDate& parse) {
  DatedColumn dated;
  for (const auto& row : sample.rows) {
    const auto time = parse(row[column]);
    if (!time) return std::nullopt;
    dated.has_zone = dated.has_zone && time->zone.has_value();
    dated.times_s.push_back(to_seconds(time->reading - time->zone.value_or(Duration{})));
    const double of_day = std::fmod(dated.times_s.back(), kDay_s);
    dated.has_time_of_day = dated.has_time_of_day || of_day != 0;
  }
  return dated;
}

/// A notation in which all dates of a column can be read.
struct DateReading {
  std::string unit{};   ///< "iso" or "date"
  std::string order{};  ///< for "date" only
  DatedColumn dated{};
};

std::vector<DateReading> find_readings(const TableSample& sample, std::size_t column) {
  std::vector<DateReading> readings;
  if (auto dated = parse_dates(sample, column, parse_civil_time)) return {{"iso", "", std::move(*dated)}};
  const auto first = std::string_view(sample.rows.front()[column]);
  const bool begins_with_year = first.substr(0, 4).find_first_not_of("0123456789") == std::string_view::npos;
  for (const auto& [order, name] :
       {std::pair(DateOrder::year_first, "year-month-day"), std::pair(DateOrder::day_first, "day-month-year"),
        std::pair(DateOrder::month_first, "month-day-year")}) {
    if (order == DateOrder::year_first && !begins_with_year) continue;
    auto dated = parse_dates(sample, column, [&](const std::string& text) { return parse_local_time(text, order); });
    if (!dated || (!readings.empty() && readings.front().dated.times_s == dated->times_s)) continue;
    readings.push_back({"date", name, std::move(*dated)});
  }
  return readings;
}

/// Removes the less likely of two notations. Dates with points have the day first. Otherwise, a notation with a much
/// shorter duration is the correct one: the wrong notation turns steps of a day into steps of a month.
void drop_less_likely(const TableSample& sample, std::size_t column, std::vector<DateReading>& readings) {
  if (readings.size() < 2) return;
  constexpr double kMinSpanRatio = 5;
  if (sample.rows.front()[column].find('.') < sample.rows.front()[column].find(':')) return readings.resize(1);
  const auto span = [](const DateReading& reading) {
    const auto [least, greatest] = std::ranges::minmax_element(reading.dated.times_s);
    return *greatest - *least;
  };
  const double one = span(readings[0]), other = span(readings[1]);
  if (one > kMinSpanRatio * other) readings.erase(readings.begin());
  if (other > kMinSpanRatio * one) readings.resize(1);
}

std::string format_date(double time_s) { return civil_time(from_seconds(time_s)).substr(0, 10); }

/// Returns the lines for the notation of a column's dates. If there are two notations, writes both as comments, and the
/// user must choose one.
std::string order_lines(const TableSample& sample, std::size_t column, const std::vector<DateReading>& readings) {
  if (readings.front().unit == "iso") return "";
  if (readings.size() == 1) return fmt::format("order = \"{}\"\n", readings.front().order);
  std::string text;
  for (const DateReading& reading : readings)
    text += fmt::format("# order = \"{}\"        # \"{}\" in column {} is then {}; which line is correct?\n",
                        reading.order, plain(sample.rows.front()[column]), toml_text(sample.column_name(column)),
                        format_date(reading.dated.times_s.front()));
  return text;
}

std::optional<std::vector<double>> parse_clocks(const TableSample& sample, std::size_t column) {
  std::vector<double> times;
  for (const auto& row : sample.rows) {
    const auto time = parse_clock(row[column]);
    if (!time) return std::nullopt;
    times.push_back(to_seconds(*time));
  }
  return times;
}

/// Finds a column that contains only times of day.
std::optional<std::size_t> clock_column(const TableSample& sample) {
  for (std::size_t i = 0; i < sample.names.size(); ++i) {
    const auto& first = sample.rows.front()[i];
    const bool has_colon = first.find(':') != std::string::npos || is_time_name(sample.column_name(i));
    if (has_colon && sample.column_numbers(i).empty() && parse_clocks(sample, i)) return i;
  }
  return std::nullopt;
}

constexpr const char* kZoneLine = "zone = \"Z\"        # the times have no zone; is it UTC?\n";

std::optional<TimeGuess> guess_dates(const TableSample& sample) {
  for (std::size_t i = 0; i < sample.names.size(); ++i) {
    if (!sample.column_numbers(i).empty() && sample.rows.front()[i].size() < 8) continue;
    auto readings = find_readings(sample, i);
    if (readings.empty()) continue;
    const std::size_t none = sample.names.size();
    const std::size_t clock = readings.front().dated.has_time_of_day ? none : clock_column(sample).value_or(none);
    if (clock != none) {
      const auto clocks = parse_clocks(sample, clock).value_or(std::vector<double>(sample.rows.size()));
      for (DateReading& reading : readings)
        for (std::size_t row = 0; row < clocks.size(); ++row) reading.dated.times_s[row] += clocks[row];
      if (readings.front().unit == "iso") readings.front() = {"date", "year-month-day", readings.front().dated};
    }
    drop_less_likely(sample, i, readings);
    const auto& [unit, order, dated] = readings.front();
    const bool runs_backwards = is_increasing({dated.times_s.rbegin(), dated.times_s.rend()});
    if (!is_increasing(dated.times_s) && !runs_backwards) continue;
    TimeGuess guess{.columns = {i}};
    if (runs_backwards) guess.text = "# The times run backwards: sort the rows by time before the import.\n";
    guess.text +=
        fmt::format("[time]\n{}\nunit = \"{}\"\n", sample.reference(i), unit) + order_lines(sample, i, readings);
    if (clock != none) {
      guess.text += sample.reference(clock, "clock") + "\n";
      guess.columns.push_back(clock);
    }
    if (!dated.has_zone) guess.text += kZoneLine;
    guess.text += course_lines(dated.times_s, 0);
    return guess;
  }
  return std::nullopt;
}

std::optional<TimeGuess> guess_clock(const TableSample& sample) {
  const auto column = clock_column(sample);
  if (!column) return std::nullopt;
  auto times = *parse_clocks(sample, *column);
  double days = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] + days < times[i - 1] - kDay_s / 2) days += kDay_s;
    times[i] += days;
  }
  if (!is_increasing(times)) return std::nullopt;
  return TimeGuess{fmt::format("[time]\n{}\nunit = \"clock\"        # a time of day; its date is not known\n",
                               sample.reference(*column)) +
                       course_lines(times, 0),
                   {*column}};
}

/// Returns the unit of times since 1970 that the size of a number suggests; empty if it suggests none.
std::string unit_since_1970(double number) {
  constexpr double kEarliest_s = 9e8, kLatest_s = 3e9;  // in seconds
  for (const char* unit : {"s", "ms", "us", "ns"})
    if (number * unit_seconds(unit) >= kEarliest_s && number * unit_seconds(unit) < kLatest_s) return unit;
  return "";
}

/// Returns the unit that the size of a number suggests: serial day numbers or LabVIEW seconds in this century. Returns
/// an empty text if it suggests neither.
std::string serial_unit(double number, double step) {
  const auto is_in = [&](double least, double most) { return number >= least && number < most; };
  const bool is_step_of_days = step > 0 && step <= 1;
  if (is_in(36526, 58440) && is_step_of_days) return "excel";      // 2000 to 2060
  if (is_in(730486, 752400) && is_step_of_days) return "matlab";   // 2000 to 2060
  if (is_in(3.029e9, 4.92e9) && step <= kDay_s) return "labview";  // 2000 to 2060
  return "";
}

/// Returns whether a step in seconds is a common interval of slow loggers.
bool is_usual_pace(double step) {
  constexpr std::array kPaces{10.0, 15.0, 20.0, 30.0, 60.0, 120.0, 180.0, 300.0, 600.0, 900.0, 1200.0, 1800.0, 3600.0};
  return std::ranges::find(kPaces, step) != kPaces.end();
}

/// Returns the largest temperature range of any thermometer, divided by the duration, in K per unit of `times`.
double thermometer_pace(const TableSample& sample, const std::vector<std::size_t>& thermometers,
                        const std::vector<double>& times) {
  double range = 0;
  for (const std::size_t column : thermometers) {
    auto numbers = sample.column_numbers(column);
    if (numbers.size() < 3) continue;
    const std::size_t margin = numbers.size() / 50;
    std::ranges::sort(numbers);
    const auto scale = celsius_scale(temperature_unit_in(sample.column_name(column)));
    constexpr double kColdest_c = -273.15, kHottest_c = 1000;
    const bool is_raw = !scale && (numbers[margin] < kColdest_c || numbers[numbers.size() - 1 - margin] > kHottest_c);
    if (is_raw) continue;  // counts
    range = std::max(range, (numbers[numbers.size() - 1 - margin] - numbers[margin]) * (scale ? scale->scale : 1));
  }
  const auto [least, greatest] = std::ranges::minmax_element(times);
  return *greatest > *least ? range / (*greatest - *least) : 0;
}

/// Returns the probable unit of a time whose column name has no unit; two units if they are equally likely.
std::vector<std::string> units_by_step(const TableSample& sample, std::size_t column,
                                       const std::vector<std::size_t>& thermometers, const std::vector<double>& times) {
  constexpr double kLongestStep_s = 5;
  constexpr double kMaxAirRate = 0.6, kMinAirRate = 0.003;  // K/s
  const double step = usual_positive_step(times);
  std::string fast = "ns";
  for (const char* unit : {"s", "ms", "us"})
    if (step * unit_seconds(unit) <= kLongestStep_s) {
      fast = unit;
      break;
    }
  if (fast != "ms") return {fast};
  const double pace_ms = thermometer_pace(sample, thermometers, times) * 1000;  // K/s if the unit is ms
  if (pace_ms >= kMaxAirRate) return {"s"};
  if (pace_ms >= kMinAirRate && pace_ms < kMaxAirRate / 2 && !is_usual_pace(step)) return {"ms"};
  const bool is_stamp = in_lower_case(sample.column_name(column)).find("stamp") != std::string::npos;
  if (is_stamp || !is_usual_pace(step)) return {"ms"};
  return {"s", "ms"};
}

std::string time_unit_questions(const TableSample& sample, std::size_t column, const std::vector<double>& times,
                                const std::vector<std::string>& units) {
  const auto [least, greatest] = std::ranges::minmax_element(times);
  std::string text;
  for (const auto& unit : units)
    text += fmt::format("# unit = \"{}\"        # column {} then spans {}; which line is correct?\n", unit,
                        toml_text(sample.column_name(column)),
                        format_duration(to_limited_duration((*greatest - *least) * unit_seconds(unit))));
  return text;
}

/// Converts times in units to seconds.
std::vector<double> convert_to_seconds(std::vector<double> times, double unit_s) {
  for (double& time : times) time *= unit_s;
  return times;
}

TimeGuess guess_numbers(const TableSample& sample, std::size_t column, const std::vector<std::size_t>& thermometers) {
  constexpr double kSlowestOfAClock_s = 600;
  const auto times = sample.column_numbers(column);
  const double step = usual_positive_step(times);
  const std::string named = time_unit_in(sample.column_name(column)), since = unit_since_1970(times.front());
  const std::string serial = serial_unit(times.front(), step);
  const bool is_named = is_unit_of_time(named);
  TimeGuess guess{fmt::format("[time]\n{}\n", sample.reference(column)), {column}};
  const auto finish = [&](const std::string& unit, std::string_view why, std::string_view more) {
    const bool counts = more.empty() && unit != "excel" && unit != "matlab" && unit != "labview";
    guess.text += fmt::format("unit = \"{}\"        # {}\n{}", unit, why, more);
    if (why.starts_with("a guess")) {
      const auto [least, greatest] = std::ranges::minmax_element(times);
      guess.text +=
          fmt::format("# The rows are then {:.3g} s apart and span {}; is this right?\n", step * unit_seconds(unit),
                      format_duration(to_limited_duration((*greatest - *least) * unit_seconds(unit))));
    }
    guess.text += course_lines(convert_to_seconds(times, unit_seconds(unit)), counts ? unit_seconds(unit) : 0);
    return guess;
  };
  constexpr const char* kSince =
      "since = \"1970-01-01T00:00:00Z\"        # inferred from the size of the numbers; is it UTC?\n";
  if (is_named && named != "d") return finish(named, "from its name", named == since ? kSince : "");
  if (!serial.empty() && serial != "labview")
    return finish(serial, "days, inferred from the size of the numbers", "zone = \"Z\"        # is it UTC?\n");
  if (is_named) return finish(named, "from its name", "");
  const auto otherwise =
      named.empty() ? std::string() : fmt::format(", the unit {} is not supported", toml_text(named));
  if (!since.empty() && step * unit_seconds(since) <= kSlowestOfAClock_s)
    return finish(since, "a guess from the size of the numbers" + otherwise, kSince);
  if (serial == "labview") return finish(serial, "seconds since 1904, inferred from the size of the numbers", "");
  const auto units = units_by_step(sample, column, thermometers, times);
  if (units.size() == 1) return finish(units.front(), "a guess from the steps of the numbers" + otherwise, "");
  guess.text += time_unit_questions(sample, column, times, units);
  return guess;
}

/// Detects a column with the week of GPS and one with the time of the week.
std::optional<TimeGuess> guess_gps(const TableSample& sample) {
  std::optional<std::size_t> week, of_week;
  for (std::size_t i = 0; i < sample.names.size(); ++i) {
    const auto name = in_lower_case(sample.column_name(i));
    if (sample.column_numbers(i).empty()) continue;
    if (name.find("week") != std::string::npos && name.find("time") == std::string::npos &&
        name.find("tow") == std::string::npos)
      week = i;
    else if (name.find("tow") != std::string::npos || name.find("time of week") != std::string::npos ||
             name.find("time_of_week") != std::string::npos || name.find("sow") != std::string::npos)
      of_week = i;
  }
  if (!week || !of_week) return std::nullopt;
  constexpr double kSecondsOfWeek = 604800;
  const auto weeks = sample.column_numbers(*week);
  auto times = sample.column_numbers(*of_week);
  const auto named = time_unit_in(sample.column_name(*of_week));
  if (weeks.size() != times.size() || (!named.empty() && named != "s")) return std::nullopt;
  for (std::size_t i = 0; i < times.size(); ++i) times[i] += weeks[i] * kSecondsOfWeek;
  if (!is_increasing(times)) return std::nullopt;
  return TimeGuess{fmt::format("[time]\n{}\nunit = \"gps\"        # seconds of the week\n{}\n",
                               sample.reference(*of_week), sample.reference(*week, "week")) +
                       course_lines(times, 0),
                   {*week, *of_week}};
}

/// Finds a column that looks like a time in an unknown notation.
std::optional<TimeGuess> find_unknown_time(const TableSample& sample) {
  for (std::size_t i = 0; i < sample.names.size(); ++i) {
    const auto looks = std::ranges::count_if(sample.rows, [&](const auto& row) { return looks_like_time(row[i]); });
    if (2 * static_cast<std::size_t>(looks) < sample.rows.size() || !sample.column_numbers(i).empty()) continue;
    return TimeGuess{fmt::format("[time]        # column {} looks like a time, \"{}\", in an unknown notation; which "
                                 "notation is it, or which other column contains the time?\n{}\n",
                                 toml_text(sample.column_name(i)), plain(sample.rows.front()[i]), sample.reference(i)),
                     {i}};
  }
  return std::nullopt;
}

}  // namespace

TimeGuess guess_time(const TableSample& sample, const std::vector<std::size_t>& thermometers) {
  if (auto guess = guess_gps(sample)) return *guess;
  if (auto guess = guess_dates(sample)) return *guess;
  const auto is_other = [&](std::size_t i) {
    return std::ranges::find(thermometers, i) != thermometers.end() || is_gyro_name(sample.column_name(i));
  };
  for (std::size_t i = 0; i < sample.names.size(); ++i)
    if (const auto numbers = sample.column_numbers(i);
        is_time_name(sample.column_name(i)) && !is_other(i) && !numbers.empty() && is_increasing(numbers))
      return guess_numbers(sample, i, thermometers);
  if (auto guess = guess_clock(sample)) return *guess;
  if (auto guess = find_unknown_time(sample)) return *guess;
  const auto increases = [](const std::vector<double>& numbers) {
    return numbers.size() > 2 && std::ranges::adjacent_find(numbers, std::greater_equal<>()) == numbers.end();
  };
  if (sample.spacing_s)
    return {fmt::format("[time]\ninterval = \"{:.9g} s\"        # Delta_X of the header\n", *sample.spacing_s), {}};
  for (std::size_t i = 0; i < sample.names.size(); ++i)
    if (!is_other(i) && increases(sample.column_numbers(i))) return guess_numbers(sample, i, thermometers);
  return {
      "[time]        # no column with increasing times was found; how many seconds are between two rows?\n"
      "# interval = \"1 s\"\n",
      {}};
}

}  // namespace gyrotherm::exchange
