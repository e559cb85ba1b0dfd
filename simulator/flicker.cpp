#include "simulator/flicker.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

namespace gyrotherm {

std::vector<MarkovProcess> flicker_processes(double instability, double shortest_s, double longest_s) {
  assert(0 < shortest_s && shortest_s <= longest_s);
  if (instability == 0) return {};
  constexpr double kPerDecade = 2;
  const double sigma = instability * std::sqrt(std::numbers::ln10 / kPerDecade / std::numbers::pi);
  const auto steps = static_cast<int>(std::lround(kPerDecade * std::log10(longest_s / shortest_s)));
  std::vector<MarkovProcess> processes;
  for (int i = 0; i <= steps; ++i) processes.push_back({sigma, shortest_s * std::pow(10, i / kPerDecade)});
  return processes;
}

Flicker::Flicker(const std::vector<MarkovProcess>& processes, RandomStream random) : random_(random) {
  for (const auto& process : processes) {
    const double memory = std::exp(-1 / process.correlation_time_s);
    const double fresh = process.sigma * std::sqrt(1 - memory * memory);
    parts_.push_back({memory, fresh, process.sigma * random_.normal()});
    sum_ += parts_.back().value;
  }
}

void Flicker::step() {
  sum_ = 0;
  for (auto& part : parts_) {
    part.value = part.memory * part.value + part.fresh * random_.normal();
    sum_ += part.value;
  }
}

}  // namespace gyrotherm
