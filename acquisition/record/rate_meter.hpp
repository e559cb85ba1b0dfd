// SPDX-License-Identifier: Apache-2.0
/// Measures the rate on each gyro axis during a run: in the last second and over the last 100 s. The types are values.
/// Only one thread may use an object.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/form.hpp"
#include "core/quantity.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// Measures one axis.
class RateMeter {
 public:
  /// `index` is the index of the axis in its unit.
  explicit RateMeter(const AxisInfo& axis, std::size_t index = 0) : axis_(axis), index_(index) {}
  void add(const Reading<GyroCount>& reading);
  /// Returns the rate in the last second; nothing if that second had no reading.
  [[nodiscard]] std::optional<DegreesPerHour> last_second() const;
  /// Returns the mean over the readings of the last 100 s; nothing if there is none.
  [[nodiscard]] std::optional<DegreesPerHour> mean() const;
  [[nodiscard]] const AxisInfo& axis() const { return axis_; }

 private:
  static constexpr std::size_t kLength = 100;
  struct Second {
    std::int64_t pulses{};
    Duration interval{};
  };
  [[nodiscard]] DegreesPerHour compute_rate(const Second& second) const;

  AxisInfo axis_;
  std::size_t index_;
  /// Ring buffer of the last kLength seconds, and the index of its next entry.
  std::vector<std::optional<Second>> seconds_;
  std::size_t next_{};
};

/// The rates of one axis in the status of a run.
struct AxisRate {
  std::string axis;  ///< "gyro", "u1.x"
  /// The rate in the last second and the mean over the last 100 s.
  std::optional<double> rate_deg_per_h{};
  std::optional<double> mean_deg_per_h{};
  /// The rate expected at rest; nothing if it is unknown.
  std::optional<double> earth_rate_deg_per_h{};
  bool operator==(const AxisRate&) const = default;
};

void describe(auto& form, Like<AxisRate> auto& axis) {
  form("axis", axis.axis);
  form("rate_deg_per_h", axis.rate_deg_per_h);
  form("mean_100s_deg_per_h", axis.mean_deg_per_h);
  form("earth_rate_deg_per_h", axis.earth_rate_deg_per_h);
}

/// Returns "gyro: 12.6 °/h in the last second, 12.58 °/h mean of 100 s, Earth rate 11.20 °/h".
[[nodiscard]] std::string describe(const AxisRate& axis);

/// Measures all axes of a rig.
class RateMeters {
 public:
  explicit RateMeters(const std::vector<UnitInfo>& units);
  void add(const Sample& sample);
  [[nodiscard]] std::vector<AxisRate> rates() const;

 private:
  struct Axis {
    std::string name;
    std::size_t unit{};
    RateMeter meter;
  };
  std::vector<Axis> axes_;
};

}  // namespace gyrotherm::record
