// SPDX-License-Identifier: Apache-2.0
#include "app/timings.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include "core/json.hpp"

namespace gyrotherm::app {
double peak_memory_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void Timings::begin(std::string stage) {
  end();
  stages_.emplace_back(std::move(stage), 0.0);
  began_ = std::chrono::steady_clock::now();
  running_ = true;
}

void Timings::end() {
  if (running_)
    stages_.back().second = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  running_ = false;
}

std::string Timings::to_json() const {
  Json json{{"schema", "gyrotherm-timings/1"}, {"stages", Json::array()}};
  double total = 0;
  for (const auto& [stage, seconds] : stages_) {
    json["stages"].push_back({{"stage", stage}, {"wall_s", seconds}});
    total += seconds;
  }
  json["total_wall_s"] = total;
  json["peak_memory_mb"] = peak_memory_mb();
  return json.dump(1) + "\n";
}

std::string Timings::words() const {
  std::string text;
  for (const auto& [stage, seconds] : stages_) text += fmt::format("  {:<52} {:8.1f} s\n", stage, seconds);
  return text + fmt::format("  {:<52} {:8.0f} MB\n", "peak memory", peak_memory_mb());
}

}  // namespace gyrotherm::app
