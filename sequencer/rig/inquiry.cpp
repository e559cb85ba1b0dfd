// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/inquiry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::rig {
namespace {

constexpr std::size_t kCalls = 10;
constexpr int kSeconds = 2;

double to_ms(Duration time) { return to_seconds(time) * 1e3; }

Result<std::vector<std::uint16_t>> read_words(const drivers::RegisterItem& item, drivers::Registers& registers) {
  const auto count = std::max<std::uint16_t>(item.read_count, word_count(item.type));
  return registers.read(item.read_function.value_or(drivers::ReadFunction::holding_registers), item.address, count);
}

/// Fails with the first fault of a channel that had a value in the first reading.
template <class Value>
Result<void> find_lost_channel(const std::vector<Result<Value>>& first, const std::vector<Result<Value>>& now) {
  for (std::size_t i = 0; i < first.size() && i < now.size(); ++i)
    if (first[i] && !now[i]) return failure(now[i].error());
  return {};
}

std::string describe_failed(const RoundTrips& trips) {
  return fmt::format("{} of {} reads failed: {}", trips.failed, kCalls, trips.fault ? text(*trips.fault) : "");
}

}  // namespace

Fault name_instrument(const std::string& title, Fault fault) {
  auto& where = fault.where;
  if (where.empty()) where = title;
  const bool is_named = where == title || where.starts_with(title + " ") || where.starts_with(title + ":");
  if (!is_named) where = title + ": " + where;
  return fault;
}

RoundTrips time_calls(const std::function<Result<void>()>& call, const Clock& clock) {
  std::vector<Duration> times;
  RoundTrips trips;
  for (std::size_t i = 0; i < kCalls; ++i) {
    const auto before = clock.now().since_start;
    if (auto done = call()) {
      times.push_back(clock.now().since_start - before);
    } else {
      ++trips.failed;
      if (!trips.fault) trips.fault = std::move(done.error());
    }
  }
  if (times.empty()) return trips;
  std::ranges::sort(times);
  trips.least = times.front();
  trips.median = (times[(times.size() - 1) / 2] + times[times.size() / 2]) / 2;
  trips.most = times.back();
  return trips;
}

std::string text(const RoundTrips& trips) {
  const auto times = fmt::format("{} reads: {:.3f}, {:.3f}, {:.3f} ms (least, median, most)", kCalls - trips.failed,
                                 to_ms(trips.least), to_ms(trips.median), to_ms(trips.most));
  return trips.failed == 0 ? times : times + "; WARNING: " + describe_failed(trips);
}

Result<void> check_calls(const RoundTrips& trips) {
  if (2 * trips.failed < kCalls) return {};
  const auto kind = trips.fault ? trips.fault->kind : FaultKind::timeout;
  return failure(kind, "", describe_failed(trips) + "; a run would lose its readings");
}

/// Uses the same shares of a second as drivers/chamber/status_turns.cpp.
std::string describe(const drivers::ChamberEffort& effort) {
  constexpr double kMaxTickTime_s = 0.95;
  constexpr int kReadingsAPiece = 5;
  if (effort.each_second == 0 || effort.longest == Duration{}) return {};
  const double exchange = to_seconds(effort.longest);
  const int needed = effort.each_second + effort.new_set_point;
  const auto spare = static_cast<int>((kMaxTickTime_s - needed * exchange) / exchange);
  const int status_s = spare > 0 ? (effort.status + spare - 1) / spare : effort.status * kReadingsAPiece;
  const auto status = effort.status == 0 ? std::string()
                                         : fmt::format("; its state and alarms, {} more, are read in turn within {} s",
                                                       effort.status, std::max(status_s, 1));
  const auto what = fmt::format("{} exchanges of {:.3f} s for air, set point and a new set point", needed, exchange);
  if (needed * exchange <= kMaxTickTime_s) return what + " fit into a second" + status;
  return fmt::format(
      "WARNING: {} do NOT fit into a second, in which {} fit{}. Readings and set points will be missing: use Modbus "
      "TCP "
      "or a faster serial line; where the unit allows it, set one_block or holes (fewer reads), seen_later for the set "
      "point, or shorter pauses in its file",
      what, static_cast<int>(kMaxTickTime_s / exchange), status);
}

Result<std::vector<drivers::OrderFinding>> find_word_orders(const drivers::RegisterMap& map,
                                                            drivers::Registers& registers) {
  const auto* air = map.find("air_temperature");
  const auto* set_point = map.find("set_point");
  std::vector<drivers::OrderFinding> none;
  if (map.text_link) return none;
  if (!air || !set_point || !set_point->readable) return none;
  if (word_count(air->type) < 2 || word_count(set_point->type) < 2) return none;
  const auto air_words = read_words(*air, registers);
  if (!air_words) return failure(air_words.error());
  const auto set_point_words = read_words(*set_point, registers);
  if (!set_point_words) return failure(set_point_words.error());
  return probe_word_order(*air, *air_words, *set_point, *set_point_words);
}

Result<std::string> query_word_order(const drivers::RegisterMap& map, drivers::Registers& registers) {
  return find_word_orders(map, registers).map([](const std::vector<drivers::OrderFinding>& findings) {
    return findings.empty() ? std::string() : describe(findings);
  });
}

Result<std::string> query_chamber(drivers::Chamber& chamber, const Clock& clock) {
  const auto name = chamber.identify();
  if (!name) return failure(name.error());
  const auto state = chamber.inspect();
  if (!state) return failure(state.error());
  const auto trips = time_calls([&] { return chamber.read().map([](const ChamberState&) {}); }, clock);
  if (auto good = check_calls(trips); !good) return failure(std::move(good.error()));
  auto line = fmt::format("{}, air {:.2f} °C, ", *name, state->air.value);
  line += std::isnan(state->set_point.value) ? "set point not shown"
                                             : fmt::format("set point {:.2f} °C", state->set_point.value);
  if (state->activity != ChamberActivity::unknown) line += fmt::format(", {}", gyrotherm::name(state->activity));
  if (const auto unmatched = chamber.unmatched_state(); !unmatched.empty())
    line += fmt::format(", WARNING: no [[state]] of its map fits {}; a run cannot tell whether it is on", unmatched);
  if (!state->alarms.empty()) line += fmt::format(", ALARMS: {}", fmt::join(state->alarms, "; "));
  const auto identity = chamber.verification();
  if (!identity.verified.empty()) line += fmt::format("; verified: {}", fmt::join(identity.verified, ", "));
  if (!identity.not_verified.empty()) line += fmt::format("; NOT verified: {}", fmt::join(identity.not_verified, ", "));
  for (const auto& one : chamber.missing())
    line += "; WARNING: not monitored, because the unit does not report it: " + one;
  const auto effort = describe(chamber.effort());
  return line + "; " + text(trips) + (effort.empty() ? "" : "; " + effort);
}

Result<std::string> query_thermometer(drivers::Thermometer& thermometer, const std::vector<std::string>& channels,
                                      const Clock& clock) {
  const auto name = thermometer.identify();
  if (!name) return failure(name.error());
  auto line = *name;
  const auto readings = thermometer.read();
  for (std::size_t i = 0; i < channels.size(); ++i)
    line += readings[i] ? fmt::format(", {} {:.3f} °C", channels[i], readings[i]->value)
                        : fmt::format(", {} {}", channels[i], readings[i].error().what);
  const auto trips = time_calls([&] { return find_lost_channel(readings, thermometer.read()); }, clock);
  if (auto good = check_calls(trips); !good) return failure(std::move(good.error()));
  line += "; " + text(trips);
  if (trips.median > kLongestScan)
    return failure(
        FaultKind::timeout, "",
        fmt::format("{}: a reading takes {:.3f} s; a run reads once a second, and {:g} s fit: reduce the number "
                    "of inputs or the time for each",
                    *name, to_seconds(trips.median), to_seconds(kLongestScan)));
  return line;
}

Result<std::string> query_analogue(drivers::AnalogueInputs& inputs, const std::vector<AnalogueReading>& channels,
                                   const Clock& clock) {
  const auto name = inputs.identify();
  if (!name) return failure(name.error());
  auto line = *name;
  const auto readings = inputs.read();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& [channel, unit, scale, offset] = channels[i];
    line += readings[i] ? fmt::format(", {} {:g} {}", channel, *readings[i] * scale + offset, unit)
                        : fmt::format(", {} {}", channel, readings[i].error().what);
  }
  const auto trips = time_calls([&] { return find_lost_channel(readings, inputs.read()); }, clock);
  if (auto good = check_calls(trips); !good) return failure(std::move(good.error()));
  return line + "; " + text(trips);
}

Result<std::string> query_supply(drivers::PowerSupply& supply, const SupplySettings& settings, const Clock& clock) {
  const auto identity = supply.identify();
  if (!identity) return identity;
  auto line = *identity;
  const auto outputs = supply.inspect();
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto title = fmt::format(", output {} ", settings.outputs[i].settings.output + 1);
    if (!outputs[i])
      return failure(outputs[i].error().kind, "", fmt::format("{}{}{}", *identity, title, outputs[i].error().what));
    const auto& [state, shown, difference] = *outputs[i];
    line += fmt::format("{}{} ({}), {:.3f} V, {:.3f} A", title, state.is_on ? "on" : "off",
                        shown.empty() ? "its settings cannot be read" : shown, state.voltage_v, state.current_a);
    if (!state.trips.empty())
      line += fmt::format(", WARNING: it has tripped ({}); clear it", fmt::join(state.trips, ", "));
    if (state.is_on && !difference.empty())
      line += fmt::format(", WARNING: it is on, but {}; a run refuses this", difference);
  }
  const auto first = supply.read();
  const auto trips = time_calls([&] { return find_lost_channel(first.outputs, supply.read().outputs); }, clock);
  if (auto good = check_calls(trips); !good) return failure(std::move(good.error()));
  line += "; " + text(trips);
  if (trips.median > kLongestScan)
    line += fmt::format(
        "; WARNING: a reading takes {:.3f} s, longer than {:g} s, so that readings will be missing: use a faster line, "
        "or "
        "fewer outputs",
        to_seconds(trips.median), to_seconds(kLongestScan));
  return line;
}

std::string describe_air_mismatch(Celsius air, const std::vector<Celsius>& thermometers) {
  constexpr Kelvins kMaxDistance{15};
  const auto distance = [&](Celsius one) { return abs(air - one); };
  const auto nearest = std::ranges::min_element(thermometers, {}, distance);
  if (nearest == thermometers.end() || distance(*nearest) <= kMaxDistance) return {};
  constexpr double kFahrenheitPerKelvin = 1.8, kZeroInFahrenheit = 32;
  const Celsius in_fahrenheit{nearest->value * kFahrenheitPerKelvin + kZeroInFahrenheit};
  return fmt::format(
      "WARNING: the chamber shows air of {:.1f} °C, the nearest thermometer {:.1f} °C{}; check the "
      "chamber's unit of temperature, and that the thermometers are in this chamber",
      air.value, nearest->value, abs(air - in_fahrenheit) <= Kelvins{5} ? ", as if the chamber showed °F" : "");
}

std::string describe_rate(const std::string& axis, DegreesPerHour measured, std::optional<DegreesPerHour> earth_rate,
                          DegreesPerHour largest_bias, DegreesPerHour one_count) {
  constexpr double kShareOfEarthRate = 0.5, kLeast_deg_per_h = 1.5;
  const auto rate = fmt::format("{} {:.2f} °/h", axis, measured.value);
  if (!earth_rate) return rate + " (Earth rate unknown: the rig file has no latitude)";
  const auto line = fmt::format("{} (Earth rate {:.2f} °/h)", rate, earth_rate->value);
  const double allowed = std::max(kShareOfEarthRate * std::abs(earth_rate->value), kLeast_deg_per_h) +
                         largest_bias.value + std::abs(one_count.value);
  if (std::abs(measured.value - earth_rate->value) <= allowed) return line;
  return fmt::format(
      "{}, WARNING: they differ by more than {:.2f} °/h; check the gyro's unit of rotation, scale, sign, axis and "
      "orientation; if the unit's bias is larger, state it (largest_bias_deg_per_h of [gyro])",
      line, allowed);
}

namespace {

/// Counts of each axis of a line, the time that they cover, and the newest housekeeping.
struct GyroMeans {
  std::vector<std::int64_t> counts;
  Duration interval{};
  std::vector<double> values{};
};

Result<GyroMeans> read_means(drivers::Gyro& gyro, std::size_t axes, const std::function<void()>& let_pass) {
  GyroMeans means{.counts = std::vector<std::int64_t>(axes)};
  for (int i = 0; i < kSeconds; ++i) {
    let_pass();
    const auto count = gyro.read(kSecond);
    if (!count) return failure(count.error());
    for (std::size_t axis = 0; axis < axes && axis < count->pulses.size(); ++axis)
      means.counts[axis] += count->pulses[axis];
    means.interval += count->interval;
    means.values = count->values;
  }
  return means;
}

std::string describe_axes(const GyroLine& line, const std::vector<UnitSettings>& units, const GyroMeans& means) {
  const double seconds = to_seconds(means.interval);
  if (!(seconds > 0)) return ", no rate, because the gyro's clock stands still";
  std::string text;
  for (const auto& share : line.shares) {
    const auto& unit = units[share.unit];
    const DegreesPerHour bias{unit.largest_bias_deg_per_h.value_or(0)};
    for (std::size_t i = 0; i < share.axes.size(); ++i) {
      const auto& axis = unit.info.axes[i];
      const auto name = unit.info.axes.size() == 1 && units.size() == 1 ? "rate" : axis_label(unit.info, i);
      const auto counts = static_cast<double>(means.counts[share.axes[i]]);
      text +=
          ", " + describe_rate(name, {counts * axis.scale / seconds}, axis.earth_rate, bias, {axis.scale / seconds});
    }
  }
  return text;
}

/// Describes the housekeeping. Skips values that no frame contained.
std::string describe_values(const drivers::FrameFormat& frame, const std::vector<double>& values) {
  const auto names = drivers::list_housekeeping(frame);
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < values.size(); ++i)
    if (std::isfinite(values[i]))
      text += fmt::format(", {} {:g}{}", names[i].name, values[i], names[i].unit == "1" ? "" : " " + names[i].unit);
  return text;
}

}  // namespace

Result<std::string> query_gyro(drivers::Gyro& gyro, const GyroLine& line, const std::vector<UnitSettings>& units,
                               bool is_simulated, const std::function<void()>& let_pass) {
  if (auto opened = gyro.open(); !opened) return failure(opened.error());
  const auto identity = gyro.identify();
  if (!identity) return failure(identity.error());
  let_pass();
  if (const auto origin = gyro.wait_for_origin(); !origin) return failure(origin.error());
  const auto before = gyro.frames();
  const auto means = read_means(gyro, std::max<std::size_t>(line.frame.axes.size(), 1), let_pass);
  if (!means) return failure(means.error());
  const auto after = gyro.frames();
  auto text = fmt::format("{} frames{}, mean of {:.3f} s", line.frame.name, identity->empty() ? "" : " of " + *identity,
                          to_seconds(means->interval)) +
              describe_axes(line, units, *means) + describe_values(line.frame, means->values) +
              fmt::format("; {} frames seen, {} lost, {} bad", after.seen - before.seen, after.lost - before.lost,
                          after.bad - before.bad);
  if (!line.stream || is_simulated) return text;
  const auto settings = describe(line.stream->settings, !line.listen_only);
  return settings.empty() ? text : text + "; " + settings;
}

}  // namespace gyrotherm::rig
