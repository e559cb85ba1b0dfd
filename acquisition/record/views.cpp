// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/views.hpp"

#include <fmt/format.h>

#include <string_view>

namespace gyrotherm::record {

namespace {

/// A number that SQL takes for a real one, to the bit.
std::string real(double number) {
  auto text = fmt::format("{}", number);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return number < 0 ? fmt::format("({})", text) : text;
}

/// The temperature that a reading of a channel stands for, as calibrated() has it.
std::string temperature(const Channel& channel) {
  const auto reading = fmt::format("\"{}\"", channel.name);
  if (channel.polynomial.empty())
    return fmt::format("{} + (SELECT offset_k FROM channel WHERE channel.name = '{}' AND channel.measures = '{}')",
                       reading, channel.name, name(Measures::temperature));
  std::string sum = real(channel.polynomial.back());
  for (std::size_t i = channel.polynomial.size() - 1; i-- > 0;)
    sum = fmt::format("({} + {} * {})", real(channel.polynomial[i]), reading, sum);
  // A constant alone would give a temperature where there was no reading.
  return channel.polynomial.size() == 1 ? fmt::format("{} + 0.0 * {}", sum, reading) : sum;
}

std::string interval_name(const RunInfo& info, std::size_t unit) {
  for (const ChannelColumn& column : channel_columns(info))
    if (column.measures == Measures::interval && column.unit == unit) return column.name;
  return "";
}

constexpr std::string_view kPulses = "pulses", kRate = "rate_deg_per_h", kNanoseconds = "ns", kSeconds = "s";

std::string rate(const ChannelColumn& column, const RunInfo& info) {
  const AxisInfo& axis = info.units[column.unit].axes[column.index];
  const auto number = fmt::format("{} * \"{}\"", real(axis.scale), column.name);
  const bool is_count = axis.kind == GyroKind::pulse_count;
  return fmt::format("{}{} AS \"{}\"", number,
                     is_count ? fmt::format(" / (\"{}\" / 1e9)", interval_name(info, column.unit)) : "",
                     calibrated_name(column));
}

std::string selected(const ChannelColumn& column, const RunInfo& info) {
  switch (column.measures) {
    case Measures::temperature:
      return fmt::format("{} AS \"{}\"", temperature(info.thermometers[column.index]), column.name);
    case Measures::rotation: return rate(column, info);
    case Measures::interval: return fmt::format("\"{}\" / 1e9 AS \"{}\"", column.name, calibrated_name(column));
    case Measures::value:
    case Measures::true_bias: break;
  }
  return fmt::format("\"{}\"", column.name);
}

std::string utc_of(std::string_view nanoseconds) {
  return fmt::format("strftime('%Y-%m-%dT%H:%M:%fZ', {} / 1e9, 'unixepoch') AS utc", nanoseconds);
}

std::string sample_view(const RunInfo& info) {
  std::string sql =
      fmt::format("SELECT slot, monotonic_ns / 1e9 AS time_s, {}, set_point_c, chamber_air_c, chamber_set_point_c",
                  utc_of("utc_ns"));
  std::string truth;
  for (const ChannelColumn& column : channel_columns(info))
    (column.measures == Measures::true_bias ? truth : sql) += ", " + selected(column, info);
  return sql +
         ", (SELECT name FROM segment WHERE segment.position = sample.segment) AS segment, (SELECT value FROM list "
         "WHERE list.name = 'cycles' AND list.of = '' AND list.position = sample.cycle) AS cycle, phase, state" +
         truth + " FROM sample";
}

std::string event_view() {
  return fmt::format(
      "SELECT id, slot, monotonic_ns / 1e9 AS time_s, {}, kind, interlock, reaction, (SELECT name FROM segment WHERE "
      "segment.position = event.segment) AS segment, channel, text FROM event",
      utc_of("nullif(utc_ns, 0)"));
}

std::string channel_view() {
  return fmt::format(
      "SELECT position, CASE measures WHEN '{0}' THEN substr(name, 1, length(name) - {1}) || '{2}' WHEN '{3}' THEN "
      "substr(name, 1, length(name) - {4}) || '{5}' ELSE name END AS name, measures, CASE measures WHEN '{0}' THEN "
      "'°/h' WHEN '{3}' THEN 's' ELSE unit END AS unit, instrument, unit_under_test, certificate, due, "
      "calibration_uncertainty_k, distribution, drift_k_per_year, calibrated FROM channel",
      name(Measures::rotation), kPulses.size(), kRate, name(Measures::interval), kNanoseconds.size(), kSeconds);
}

}  // namespace

std::string calibrated_name(const ChannelColumn& column) {
  const auto with = [&](std::string_view ending, std::string_view by) {
    return column.name.substr(0, column.name.size() - ending.size()).append(by);
  };
  if (column.measures == Measures::rotation) return with(kPulses, kRate);
  if (column.measures == Measures::interval) return with(kNanoseconds, kSeconds);
  return column.name;
}

std::vector<View> views_of(const RunInfo& info) {
  std::vector<View> views{{"v1_channel", channel_view()},
                          {"v1_event", event_view()},
                          {"v1_gap", "SELECT first, last, last - first + 1 AS seconds, cause FROM gap"},
                          {"v1_sample", sample_view(info)}};
  for (View& view : views) view.sql = fmt::format("CREATE VIEW {} AS {}", view.name, view.sql);
  return views;
}

}  // namespace gyrotherm::record
