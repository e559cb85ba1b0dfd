// SPDX-License-Identifier: Apache-2.0
#include "app/run/display.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/clock.hpp"

namespace gyrotherm::app {
namespace {

std::string degrees(double value) { return std::isnan(value) ? "unknown" : fmt::format("{:.2f} °C", value); }

std::string format_bias(const std::optional<DegreesPerHour>& bias) {
  return bias ? fmt::format("{:+.4f} °/h", bias->value) : "unknown";
}

std::string chamber_line(const Sample& sample) {
  const auto asked = degrees(sample.progress.set_point.value);
  if (!sample.chamber.value) return fmt::format("set point {}, chamber: {}", asked, sample.chamber.value.error().what);
  const auto& state = *sample.chamber.value;
  return fmt::format("set point {} (chamber {}), air {}", asked, degrees(state.set_point.value),
                     degrees(state.air.value));
}

}  // namespace

void BiasMeter::see(const Reading<GyroCount>& reading) {
  if (seconds_.size() == kLength) seconds_.erase(seconds_.begin());
  const bool counts = reading.value && reading.value->interval > Duration{} && index_ < reading.value->pulses.size();
  seconds_.push_back(counts ? std::optional(Second{reading.value->pulses[index_], reading.value->interval})
                            : std::nullopt);
}

/// 1 arcsec/s is 1 °/h exactly.
DegreesPerHour BiasMeter::bias_of(const Second& second) const {
  const auto number = static_cast<double>(second.pulses);
  const double rate =
      axis_.kind == record::GyroKind::rate ? axis_.scale * number : axis_.scale * number / to_seconds(second.interval);
  return {rate - axis_.earth_rate.value_or(DegreesPerHour{}).value};
}

std::optional<DegreesPerHour> BiasMeter::last_second() const {
  if (seconds_.empty() || !seconds_.back()) return {};
  return bias_of(*seconds_.back());
}

std::optional<DegreesPerHour> BiasMeter::mean() const {
  double sum = 0, weight = 0;
  for (const auto& second : seconds_) {
    if (!second) continue;
    sum += bias_of(*second).value * to_seconds(second->interval);
    weight += to_seconds(second->interval);
  }
  if (weight <= 0) return {};
  return DegreesPerHour{sum / weight};
}

Display::Display(Console& console, const profile::Profile& profile, const rig::RigFile& rig)
    : console_(console), profile_(profile), rig_(rig), channels_(channels_of(rig)) {
  for (const auto& unit : rig.units) {
    auto& axes = bias_.emplace_back();
    for (std::size_t i = 0; i < unit.info.axes.size(); ++i) axes.emplace_back(unit.info.axes[i], i);
  }
}

void Display::see(const Sample& sample) {
  for (std::size_t unit = 0; unit < sample.units.size() && unit < bias_.size(); ++unit)
    for (auto& axis : bias_[unit]) axis.see(sample.units[unit].count);
}

/// Of one gyro alone both biases, of a unit among several the mean of each axis.
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

std::string Display::headline(const Sample& sample, const RunStanding& standing) const {
  const auto done = static_cast<double>(sample.slot + 1), left = to_seconds(standing.time_left.value_or(Duration{}));
  auto line = fmt::format("{}{}: {:.0f} %, {} left, {}", rig_.simulated ? "SIMULATED " : "", profile_.name,
                          100 * done / std::max(done + left, 1.0), spoken(standing.time_left.value_or(Duration{})),
                          name(standing.state));
  if (!standing.cause.empty()) line += ": " + standing.cause;
  if (standing.behind_plan >= std::chrono::seconds(1))
    line += fmt::format(" ({} behind plan)", spoken(*standing.behind_plan));
  return line;
}

std::vector<std::string> Display::lines(const Sample& sample, const RunStanding& standing) const {
  std::vector<std::string> all{headline(sample, standing)};
  if (standing.state == RunState::held)
    all.emplace_back("  goes on with \"gyrotherm tell RUN.db resume\", in another terminal");
  const auto segment = static_cast<std::size_t>(std::max(sample.progress.segment, 0));
  if (segment < profile_.segments.size())
    all.push_back(fmt::format("  segment {} of {}, {}: {}, {}", segment + 1, profile_.segments.size(),
                              profile_.segments[segment].name, name(sample.progress.phase),
                              spoken(sample.progress.in_segment)));
  all.push_back("  " + chamber_line(sample));
  std::string temperatures = " ";
  for (std::size_t i = 0; i < sample.thermometers.size() && i < channels_.size(); ++i) {
    const auto& reading = sample.thermometers[i].value;
    temperatures += fmt::format(" {} {}", channels_[i].name, reading ? fmt::format("{:.2f}", reading->value) : "–");
  }
  all.push_back(temperatures + " °C");
  for (std::size_t unit = 0; unit < bias_.size(); ++unit) all.push_back(unit_line(unit));
  for (const auto& fault : standing.faults_now) all.push_back("  fault: " + fault);
  return all;
}

void Display::show(const Sample& sample, const RunStanding& standing) {
  const bool turned = sample.progress.segment != shown_segment_ || standing.state != shown_state_;
  shown_segment_ = sample.progress.segment;
  shown_state_ = standing.state;
  console_.panel([&] { return lines(sample, standing); }, turned && !rig_.simulated);
}

}  // namespace gyrotherm::app
