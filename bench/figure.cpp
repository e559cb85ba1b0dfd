#include "bench/figure.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace gyrotherm {

void print_figure(const std::string& name, std::optional<double> value, Goal goal, bool premise) {
  const bool least = goal.sense == GoalSense::at_least;
  const bool reached = value && premise && (least ? *value >= goal.limit : *value <= goal.limit);
  fmt::print("{}\t{}\t{} {:g}\t{}\n", name, value ? fmt::format("{:.4g}", *value) : "none",
             least ? ">=" : "<=", goal.limit, reached ? "ok" : "short");
  std::fflush(stdout);
}

}  // namespace gyrotherm
