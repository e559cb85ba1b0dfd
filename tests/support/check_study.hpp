// SPDX-License-Identifier: Apache-2.0
/// Simulated histories of check runs with an injected change, and what the charts and the diagnosis make of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/assurance/history.hpp"

namespace gyrotherm::tests {

/// Golden gyro of a simulated rig. `single`: one vertical axis. `turned`: the same, also measured turned around.
/// `triad`: three axes in a fixture as in profiles/rigs/virtual-triad.toml.
enum class GoldenGyro { single, turned, triad };
[[nodiscard]] const char* name(GoldenGyro golden);

enum class Injected { none, thermometer, mount, gyro };
[[nodiscard]] const char* name(Injected injected);

/// Scatter of the results from run to run: standard deviations. The defaults are those of 20 check runs of each of the
/// rigs virtual and virtual-triad (docs/check-standard.md).
struct RunScatter {
  double bias_common = 1.15e-3;  ///< °/h, of all plateaus of an axis: turn-on
  double bias_own = 4.5e-4;      ///< °/h, of each plateau
  double thermometer_common_k = 7e-3;
  double thermometer_own_k = 4e-4;
  double scatter_deg_per_h = 1.9e-3;  ///< mean of the scatter; it has 14 degrees of freedom on each plateau
};

struct StudyOptions {
  GoldenGyro golden{};
  Injected injected{};
  int seeds = 200;
  int runs = 40;
  double false_alarm_rate = 0.01;
  double thermometer_k = 0.05, tilt_deg = 0.1, drift_deg_per_h = 0.002;
  /// First and last run that the change may begin with, counted from 0.
  int earliest = 12, latest = 30;
  /// Number of runs over which the change grows; 1: a step.
  int grows_over = 1;
  /// Check runs that are repeated after an alarm until a cause is named.
  int repeats = 3;
  RunScatter scatter{};
};

struct StudyResult {
  int judged_runs{}, false_alarms{};             ///< in control
  std::vector<int> runs_to_detection;            ///< 1: the first run with the change; only detected changes
  int detected{}, right{}, wrong{}, not_told{};  ///< counts of the detected changes
};

/// Simulates the histories. A false alarm is explained as a false alarm at once. A change is diagnosed in the run of
/// its alarm and, until a cause is named, in the next runs.
[[nodiscard]] StudyResult simulate_histories(const StudyOptions& options);

/// Makes one history without explanations. `from` is the first run with the change.
[[nodiscard]] assurance::History make_history(const StudyOptions& options, std::uint64_t seed, int from);

/// Return the median, and the value that 95 % do not exceed; NaN if empty.
[[nodiscard]] double median(std::vector<int> values);
[[nodiscard]] double quantile_95(std::vector<int> values);

struct BinomialInterval {
  double low{}, high{};
};
/// Returns the 95 % interval of a probability (Wilson, J. Am. Stat. Assoc. 22 (1927) 209).
[[nodiscard]] BinomialInterval binomial_interval(int successes, int trials);

}  // namespace gyrotherm::tests
