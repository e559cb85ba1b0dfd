// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/rate_meter.hpp"

#include <fmt/format.h>

namespace gyrotherm::record {

void RateMeter::add(const Reading<GyroCount>& reading) {
  const bool counts = reading.value && reading.value->interval > Duration{} && index_ < reading.value->pulses.size();
  const auto second =
      counts ? std::optional(Second{reading.value->pulses[index_], reading.value->interval}) : std::nullopt;
  if (seconds_.size() < kLength)
    seconds_.push_back(second);
  else
    seconds_[next_] = second;
  next_ = (next_ + 1) % kLength;
}

/// Returns the rate of one second. 1 arcsec/s is exactly 1 °/h.
DegreesPerHour RateMeter::compute_rate(const Second& second) const {
  const auto number = axis_.scale * static_cast<double>(second.pulses);
  return {axis_.kind == GyroKind::rate ? number : number / to_seconds(second.interval)};
}

std::optional<DegreesPerHour> RateMeter::last_second() const {
  if (seconds_.empty()) return {};
  const auto& newest = seconds_[(next_ + kLength - 1) % kLength];
  return newest ? std::optional(compute_rate(*newest)) : std::nullopt;
}

std::optional<DegreesPerHour> RateMeter::mean() const {
  double sum = 0, weight = 0;
  for (const auto& second : seconds_) {
    if (!second) continue;
    sum += compute_rate(*second).value * to_seconds(second->interval);
    weight += to_seconds(second->interval);
  }
  if (weight <= 0) return {};
  return DegreesPerHour{sum / weight};
}

namespace {

std::string describe(const std::optional<double>& rate_deg_per_h) {
  return rate_deg_per_h ? fmt::format("{:.4f} °/h", *rate_deg_per_h) : "unknown";
}

std::optional<double> to_number(const std::optional<DegreesPerHour>& rate) {
  return rate ? std::optional(rate->value) : std::nullopt;
}

}  // namespace

std::string describe(const AxisRate& axis) {
  return fmt::format("{}: {} in the last second, {} mean of 100 s, Earth rate {}", axis.axis,
                     describe(axis.rate_deg_per_h), describe(axis.mean_deg_per_h), describe(axis.earth_rate_deg_per_h));
}

RateMeters::RateMeters(const std::vector<UnitInfo>& units) {
  for (std::size_t unit = 0; unit < units.size(); ++unit)
    for (std::size_t i = 0; i < units[unit].axes.size(); ++i)
      axes_.push_back({axis_label(units[unit], i), unit, RateMeter(units[unit].axes[i], i)});
}

void RateMeters::add(const Sample& sample) {
  for (auto& axis : axes_)
    if (axis.unit < sample.units.size()) axis.meter.add(sample.units[axis.unit].count);
}

std::vector<AxisRate> RateMeters::rates() const {
  std::vector<AxisRate> rates;
  for (const auto& [name, unit, meter] : axes_)
    rates.push_back({.axis = name,
                     .rate_deg_per_h = to_number(meter.last_second()),
                     .mean_deg_per_h = to_number(meter.mean()),
                     .earth_rate_deg_per_h = to_number(meter.axis().earth_rate)});
  return rates;
}

}  // namespace gyrotherm::record
