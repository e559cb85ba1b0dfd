// SPDX-License-Identifier: Apache-2.0
#include "bench/measurement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>

namespace gyrotherm::bench {
namespace {

double read_seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void print_figure(const std::string& name, std::optional<double> value, Goal goal, bool premise) {
  const bool least = goal.sense == GoalSense::at_least;
  const bool reached = value && premise && (least ? *value >= goal.limit : *value <= goal.limit);
  fmt::print("{}\t{}\t{} {:g}\t{}\n", name, value ? fmt::format("{:.4g}", *value) : "none",
             least ? ">=" : "<=", goal.limit, reached ? "ok" : "short");
  std::fflush(stdout);
}

double thread_seconds() { return read_seconds(CLOCK_THREAD_CPUTIME_ID); }

double wall_seconds() { return read_seconds(CLOCK_MONOTONIC); }

double median(std::vector<double> values) {
  assert(!values.empty());
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double median_seconds(int least, const std::function<void()>& work) {
  constexpr double kEnough = 0.2;
  constexpr std::size_t kMost = 100;
  std::vector<double> times;
  double total = 0;
  while (times.size() < static_cast<std::size_t>(least) || (total < kEnough && times.size() < kMost)) {
    const double start = thread_seconds();
    work();
    times.push_back(thread_seconds() - start);
    total += times.back();
  }
  return median(times);
}

double peak_memory() {
  std::ifstream status("/proc/self/status");
  std::string key;
  double kibibytes = 0;
  while (status >> key) {
    if (key == "VmHWM:" && status >> kibibytes) return kibibytes * 1024;
    status.ignore(1 << 20, '\n');
  }
  return 0;
}

void print_progress(const std::string& text) {
  double load = 0;
  getloadavg(&load, 1);
  fmt::print(stderr, "[load {:.2f}] {}\n", load, text);
}

}  // namespace gyrotherm::bench
