// SPDX-License-Identifier: Apache-2.0
/// What the benchmarks measure and how they say it: on stdout one line per figure, tab-separated: name, value, goal,
/// "ok" or "short". Time is of one thread's processor for one thread, of the wall for more.
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

/// Prints the line. A figure without a value (it could not be had), and one whose premise does not hold (the answer was
/// not equal, so its time counts for nothing), are short.
void print_figure(const std::string& name, std::optional<double> value, Goal goal, bool premise = true);

/// Processor time of the calling thread, s (CLOCK_THREAD_CPUTIME_ID).
[[nodiscard]] double thread_seconds();
/// Wall clock, s, from an arbitrary instant (CLOCK_MONOTONIC).
[[nodiscard]] double wall_seconds();

/// Of at least one value; the mean of the middle two of an even number.
[[nodiscard]] double median(std::vector<double> values);

/// Median thread_seconds() of `work`, which runs at least `least` times and, up to 100 times, for at least a fifth of a
/// second.
[[nodiscard]] double median_seconds(int least, const std::function<void()>& work);

/// The most memory that this process has held, bytes (VmHWM); 0 if the system does not tell.
[[nodiscard]] double peak_memory();

/// Says one line of progress on stderr, with the load average of the last minute.
void say_progress(const std::string& text);

}  // namespace gyrotherm::bench
