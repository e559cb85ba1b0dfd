// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/display.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "core/clock.hpp"
#include "core/json.hpp"

namespace gyrotherm::app {
namespace {

/// Returns "Wed 25 Nov 19:40 UTC".
std::string weekday_and_hour(Duration utc) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(utc).count();
  return fmt::format("{:%a %d %b %H:%M} UTC", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::string degrees(double value) { return std::isnan(value) ? "unknown" : fmt::format("{:.2f} °C", value); }

std::string format_bias(const std::optional<DegreesPerHour>& bias) {
  return bias ? fmt::format("{:+.4f} °/h", bias->value) : "unknown";
}

std::string chamber_line(const Sample& sample) {
  const auto set_point = degrees(sample.progress.set_point.value);
  if (!sample.chamber.value)
    return fmt::format("set point {}, chamber: {}", set_point, sample.chamber.value.error().what);
  const auto& state = *sample.chamber.value;
  return fmt::format("set point {} (chamber {}), air {}", set_point, degrees(state.set_point.value),
                     degrees(state.air.value));
}

/// Returns the newest alarms that await an acknowledgement, the count of all, and the count of the shelved ones.
std::vector<std::string> alarm_lines(std::span<const record::Alarm> alarms) {
  constexpr std::size_t kMaxListedAlarms = 3;
  std::vector<std::string> lines;
  for (const auto& alarm : alarms)
    if (alarm.awaits_acknowledgement() && lines.size() < kMaxListedAlarms)
      lines.push_back(fmt::format("  ALARM {} ({}{}): {}", alarm.number, describe_alarm_state(alarm),
                                  alarm.count > 1 ? fmt::format(", {} times", alarm.count) : "", alarm.text));
  if (const auto count = count_unacknowledged(alarms); count > kMaxListedAlarms)
    lines.push_back(fmt::format("  {} unacknowledged alarms", count));
  if (const auto shelved = std::ranges::count_if(alarms, &record::Alarm::is_shelved); shelved > 0)
    lines.push_back(fmt::format("  {} shelved {}", shelved, shelved == 1 ? "alarm" : "alarms"));
  return lines;
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json unit_json(const UnitReading& reading, const record::UnitInfo& unit) {
  Json json{{"pulses", Json::object()}, {"interval_s", nullptr}, {"values", Json::object()}};
  const auto* count = reading.count.value ? &*reading.count.value : nullptr;
  for (std::size_t i = 0; i < unit.axes.size(); ++i)
    json["pulses"][unit.axes[i].name.empty() ? unit.name : unit.axes[i].name] =
        count && i < count->pulses.size() ? Json(count->pulses[i]) : Json(nullptr);
  if (count && count->interval > Duration{}) json["interval_s"] = to_seconds(count->interval);
  const auto sent = unit.values.size() - std::min(unit.values.size(), reading.analogue.size());
  for (std::size_t i = 0; i < unit.values.size(); ++i) {
    const auto& name = unit.values[i].name;
    if (i < sent)
      json["values"][name] = count && i < count->values.size() ? number_or_null(count->values[i]) : Json(nullptr);
    else
      json["values"][name] =
          reading.analogue[i - sent].value ? number_or_null(*reading.analogue[i - sent].value) : Json(nullptr);
  }
  return json;
}

}  // namespace

std::optional<DegreesPerHour> BiasMeter::subtract_earth_rate(std::optional<DegreesPerHour> rate) const {
  if (rate) rate->value -= meter_.axis().earth_rate.value_or(DegreesPerHour{}).value;
  return rate;
}

Display::Display(Console& console, const profile::Profile& profile, const rig::RigFile& rig, bool is_simulated)
    : console_(console), profile_(profile), rig_(rig), is_simulated_(is_simulated), channels_(list_channels(rig)) {
  for (const auto& unit : rig.units) {
    auto& axes = bias_.emplace_back();
    for (std::size_t i = 0; i < unit.info.axes.size(); ++i) axes.emplace_back(unit.info.axes[i], i);
  }
}

void Display::add_sample(const Sample& sample) {
  if (!first_seen_) first_seen_ = {sample.slot, clock_.now().since_start};
  for (std::size_t unit = 0; unit < sample.units.size() && unit < bias_.size(); ++unit)
    for (auto& axis : bias_[unit]) axis.add_reading(sample.units[unit].count);
}

/// Returns both biases of a single gyro, or the mean bias of each axis of a unit.
std::string Display::unit_line(std::size_t unit) const {
  const auto& axes = bias_[unit];
  if (bias_.size() == 1 && axes.size() == 1)
    return fmt::format("  bias {}, mean of 100 s {}", format_bias(axes[0].last_second()), format_bias(axes[0].mean()));
  std::string line = fmt::format("  {} bias, mean of 100 s:", rig_.units[unit].info.name);
  for (std::size_t i = 0; i < axes.size(); ++i)
    line += fmt::format(" {}{}", axes.size() > 1 ? rig_.units[unit].info.axes[i].name + " " : "",
                        format_bias(axes[i].mean()));
  return line;
}

std::string Display::headline(const Sample& sample, const RunOverview& overview) const {
  // Seconds with a stopped clock are no progress.
  const auto done = static_cast<double>(sample.slot + 1) - to_seconds(overview.behind_plan.value_or(Duration{}));
  const auto left = to_seconds(overview.time_left.value_or(Duration{}));
  const auto wall_time_left = time_left(sample, overview);
  const bool has_no_time_left = overview.state == RunState::aborting || overview.state == RunState::aborted ||
                                overview.state == RunState::complete;
  const auto share =
      overview.time_left ? fmt::format("{:.0f} %, ", 100 * std::max(done, 0.0) / std::max(done + left, 1.0)) : "";
  const auto time = wall_time_left ? format_duration(*wall_time_left) + " left, " : "time left unknown, ";
  auto line = fmt::format("{}{}: {}{}{}", is_simulated_ ? "SIMULATED " : "", profile_.name, share,
                          has_no_time_left ? "" : time, name(overview.state));
  if (!overview.cause.empty()) line += ": " + overview.cause;
  if (overview.behind_plan >= std::chrono::seconds(1))
    line += fmt::format(" ({} behind plan)", format_duration(*overview.behind_plan));
  return line;
}

std::optional<Duration> Display::time_left(const Sample& sample, const RunOverview& overview) const {
  if (!overview.time_left) return {};
  const auto left = *overview.time_left;
  if (!rig_.simulated) return left;
  constexpr Duration kMinObservedTime = std::chrono::milliseconds(400);
  const auto spent = clock_.now().since_start - (first_seen_ ? first_seen_->second : clock_.now().since_start);
  const auto passed = static_cast<double>(sample.slot - (first_seen_ ? first_seen_->first : sample.slot));
  if (spent < kMinObservedTime || passed < 1) return {};
  return from_seconds(to_seconds(spent) / passed * to_seconds(left));
}

/// Returns the wall-clock time now and at the end.
std::string Display::clock_line(const Sample& sample, const RunOverview& overview) const {
  const auto now = clock_.now().utc;
  auto line = fmt::format("  {}", civil_time(now));
  if (const auto left = time_left(sample, overview)) line += ", ends " + weekday_and_hour(now + *left);
  return line;
}

/// Distributes the readings over lines that fit the narrowest terminal.
std::vector<std::string> Display::temperature_lines(const Sample& sample) const {
  constexpr std::size_t kMinTerminalWidth = 60;
  std::vector<std::string> all{" "};
  const auto count = std::min(sample.thermometers.size(), channels_.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto& reading = sample.thermometers[i].value;
    auto entry = fmt::format(" {} {}", channels_[i].name, reading ? fmt::format("{:.2f}", reading->value) : "–");
    if (i + 1 == count) entry += " °C";
    if (all.back().size() > 1 && all.back().size() + entry.size() > kMinTerminalWidth) all.emplace_back(" ");
    all.back() += entry;
  }
  return all;
}

std::vector<std::string> Display::lines(const Sample& sample, const RunOverview& overview,
                                        std::span<const record::Alarm> alarms, const std::string& goal) const {
  std::vector<std::string> all{headline(sample, overview)};
  if (overview.state == RunState::held)
    all.emplace_back("  to continue: \"gyrotherm tell RUN.db resume\" in another terminal");
  all.push_back(clock_line(sample, overview));
  if (rig_.simulated && overview.time_left)
    all.push_back(fmt::format("  {} of simulated time left", format_duration(*overview.time_left)));
  const auto segment = static_cast<std::size_t>(std::max(sample.progress.segment, 0));
  if (segment < profile_.segments.size())
    all.push_back(fmt::format("  segment {} of {}, {}: {}, {}", segment + 1, profile_.segments.size(),
                              profile_.segments[segment].name, name(sample.progress.phase),
                              format_duration(sample.progress.in_segment)));
  if (!goal.empty()) all.push_back("  " + goal);
  all.push_back("  " + chamber_line(sample));
  for (const auto& fault : overview.faults_now) all.push_back("  fault: " + fault);
  for (auto& line : alarm_lines(alarms)) all.push_back(std::move(line));
  for (std::size_t unit = 0; unit < bias_.size(); ++unit) all.push_back(unit_line(unit));
  // The temperatures of a lot may need more lines than a small terminal has, so they come last.
  for (auto& line : temperature_lines(sample)) all.push_back(std::move(line));
  return all;
}

void Display::show(const Sample& sample, const RunOverview& overview, std::span<const record::Alarm> alarms,
                   const std::string& goal) {
  const bool turned = sample.progress.segment != shown_segment_ || overview.state != shown_state_;
  shown_segment_ = sample.progress.segment;
  shown_state_ = overview.state;
  console_.panel([&] { return lines(sample, overview, alarms, goal); }, turned && !rig_.simulated);
}

std::string sample_json(const Sample& sample, std::span<const Event> events, const record::RunInfo& info) {
  const auto chamber = known_value(sample.chamber);
  const auto segment = static_cast<std::size_t>(sample.progress.segment);
  Json json{{"slot", sample.slot},
            {"time_s", to_seconds(sample.at.since_start)},
            {"utc", civil_time(sample.at.utc)},
            {"state", name(sample.state)},
            {"segment", segment < info.segments.size() ? Json(info.segments[segment].name) : Json(nullptr)},
            {"phase", name(sample.progress.phase)},
            {"set_point_c", number_or_null(sample.progress.set_point.value)},
            {"chamber_air_c", chamber ? number_or_null(chamber->air.value) : Json(nullptr)},
            {"chamber_set_point_c", chamber ? number_or_null(chamber->set_point.value) : Json(nullptr)},
            {"thermometers_c", Json::object()},
            {"units", Json::object()},
            {"events", Json::array()}};
  for (std::size_t i = 0; i < sample.thermometers.size() && i < info.thermometers.size(); ++i) {
    const auto reading = known_value(sample.thermometers[i]);
    json["thermometers_c"][info.thermometers[i].name] = reading ? number_or_null(reading->value) : Json(nullptr);
  }
  for (std::size_t i = 0; i < sample.units.size() && i < info.units.size(); ++i)
    json["units"][info.units[i].name] = unit_json(sample.units[i], info.units[i]);
  for (const auto& event : events) json["events"].push_back({{"kind", name(event.kind)}, {"text", event.text}});
  return json_text(json);
}

}  // namespace gyrotherm::app
