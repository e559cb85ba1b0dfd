/// What the benchmark says on stdout: one line per figure, tab-separated: name, value, goal, "ok" or "short".
#pragma once

#include <optional>
#include <string>

namespace gyrotherm {

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

}  // namespace gyrotherm
