// SPDX-License-Identifier: Apache-2.0
/// Measurement and output of the benchmarks. Each figure is a tab-separated line on stdout: name, value, goal, "ok" or
/// "short". Times are processor times for one thread, wall times for several.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace gyrotherm::bench {

enum class GoalSense { at_least, at_most };

struct Goal {
  GoalSense sense{};
  double limit{};
};
[[nodiscard]] constexpr Goal at_least(double limit) { return {GoalSense::at_least, limit}; }
[[nodiscard]] constexpr Goal at_most(double limit) { return {GoalSense::at_most, limit}; }

/// Prints the line of a figure. The figure is "short" if it misses its goal, has no value, or if `premise` is false:
/// the compared results were not equal, and the time is therefore not valid.
void print_figure(const std::string& name, std::optional<double> value, Goal goal, bool premise = true);

/// Returns the processor time of the calling thread, s (CLOCK_THREAD_CPUTIME_ID).
[[nodiscard]] double thread_seconds();
/// Returns the wall clock, s, from an arbitrary instant (CLOCK_MONOTONIC).
[[nodiscard]] double wall_seconds();

/// Returns the median of at least one value. For an even number of values, this is the mean of the middle two.
[[nodiscard]] double median(std::vector<double> values);

/// Returns the median thread_seconds() of `work`. Runs `work` at least `least` times, and repeats it until it has taken
/// a fifth of a second in total, at most 100 times.
[[nodiscard]] double median_seconds(int least, const std::function<void()>& work);

/// Returns the peak memory of this process, bytes (VmHWM); 0 if the system does not report it.
[[nodiscard]] double peak_memory();

/// Prints one line of progress on stderr, with the load average of the last minute.
void print_progress(const std::string& text);

}  // namespace gyrotherm::bench
