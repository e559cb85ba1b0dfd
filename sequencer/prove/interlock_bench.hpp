// SPDX-License-Identifier: Apache-2.0
/// A dry instance of the interlocks with the settings of a rig: readings of a rig without faults, one second per step,
/// into which a proof test injects values.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sequencer/interlocks/interlocks.hpp"

namespace gyrotherm::prove {

class InterlockBench {
 public:
  /// `base` is the temperature of the air and, as far as their limits permit, of the thermometers.
  InterlockBench(const interlocks::InterlockLimits& limits, Celsius base) : limits_(limits), base_(base) {}

  /// The readings of the next second, for injections.
  Sample sample;
  interlocks::InterlockInputs inputs;
  /// Values that replace the base from now on.
  Celsius air{}, set_point{};
  std::vector<std::optional<Celsius>> thermometers{};
  /// All readings repeat the last ones.
  bool is_frozen = false;
  /// The axes deliver no counts.
  bool is_dead = false;
  Duration elapsed = kSecond;

  [[nodiscard]] const interlocks::InterlockLimits& limits() const { return limits_; }
  [[nodiscard]] Celsius base() const { return base_; }
  [[nodiscard]] ChamberState& chamber() { return *sample.chamber.value; }
  [[nodiscard]] Celsius thermometer_base(std::size_t column) const {
    const auto own = own_limits(column);
    constexpr Kelvins kMargin{1};
    return std::clamp(base_, std::min(own.lowest + kMargin, own.highest), own.highest);
  }
  [[nodiscard]] interlocks::ThermometerLimits own_limits(std::size_t column) const {
    return column < limits_.thermometers.size()
               ? limits_.thermometers[column]
               : interlocks::ThermometerLimits{limits_.thermometers_lowest, limits_.thermometers_highest};
  }

  /// Starts with readings without faults.
  void begin() {
    air = set_point = base_;
    thermometers.assign(limits_.channels.size(), std::nullopt);
    counts_.clear();
  }
  /// Fills the sample with readings without faults; injections follow.
  void fill() {
    sample.at.since_start += elapsed;
    sample.at.utc += elapsed;
    sample.chamber.value = ChamberState{noisy(air, 0.02), set_point, ChamberActivity::running};
    sample.thermometers.resize(limits_.channels.size());
    for (std::size_t i = 0; i < thermometers.size(); ++i)
      sample.thermometers[i].value = noisy(thermometers[i].value_or(thermometer_base(i)), 0.01);
    fill_units();
    inputs.sent = set_point;
  }
  /// Evaluates the second. Returns the alarms raised in it.
  std::vector<interlocks::InterlockAlarm> judge() {
    auto result = interlocks::judge(limits_, std::move(memory_), sample, elapsed, inputs);
    memory_ = std::move(result.memory);
    return result.raised;
  }

 private:
  [[nodiscard]] double noise() {
    constexpr std::uint32_t kFactor = 1664525, kStep = 1013904223;
    random_ = random_ * kFactor + kStep;
    return static_cast<double>(random_ >> 16) / 65536 - 0.5;
  }
  [[nodiscard]] Celsius noisy(Celsius value, double amplitude_k) {
    if (is_frozen) return value;
    return {std::round((value.value + amplitude_k * 4 * noise()) * 1000) / 1000};
  }
  void fill_units() {
    sample.units.resize(limits_.units.size());
    std::size_t next = 0;
    for (std::size_t i = 0; i < limits_.units.size(); ++i) {
      GyroCount count{.pulses = {}, .interval = elapsed};
      for (const auto& axis : limits_.units[i].axes) {
        if (next == counts_.size()) counts_.push_back(0);
        const double pulses = axis.earth_rate.value_or(DegreesPerHour{}).value / axis.arcsec_per_count;
        const double whole = counts_[next] + (is_dead ? 0 : pulses + 4 * noise());
        count.pulses.push_back(is_dead ? 0 : std::llround(whole));
        counts_[next] = whole - static_cast<double>(count.pulses.back());
        ++next;
      }
      sample.units[i].count.value = std::move(count);
      sample.units[i].analogue.assign(limits_.units[i].analogue.size(), {1.0, {}});
    }
  }

  interlocks::InterlockLimits limits_;
  Celsius base_;
  interlocks::InterlockMemory memory_;
  std::vector<double> counts_;  ///< fractions of pulses that are carried over
  std::uint32_t random_ = 1;
};

}  // namespace gyrotherm::prove
