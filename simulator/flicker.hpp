/// Bias instability: noise whose Allan deviation is flat over decades of averaging time.
#pragma once

#include <cstdint>
#include <vector>

#include "core/random.hpp"

namespace gyrotherm {

/// A stationary first-order Markov (Ornstein-Uhlenbeck) process.
struct MarkovProcess {
  double sigma{};
  double correlation_time_s{};
};

/// Processes, two a decade, whose spectra add up to flicker noise of level `instability` = B from frequency
/// 1/(2π longest_s) to 1/(2π shortest_s): two-sided S(f) = B²/(2πf), Allan deviation B √(2 ln 2/π) between (IEEE Std
/// 952, annex C). Equal variances at times spaced evenly on a logarithmic scale give that: ∫ 2σ²τ/(1 + (2πfτ)²) d ln τ
/// = σ²/(2f), so σ² = B²/π per unit of ln τ. Asserts 0 < shortest_s ≤ longest_s.
[[nodiscard]] std::vector<MarkovProcess> flicker_processes(double instability, double shortest_s, double longest_s);

/// The sum of such processes, once a second.
class Flicker {
 public:
  /// Starts from the stationary distribution.
  Flicker(const std::vector<MarkovProcess>& processes, RandomStream random);

  void step();
  [[nodiscard]] double value() const { return sum_; }

 private:
  struct Part {
    double memory;  ///< per second
    double fresh;
    double value;
  };
  std::vector<Part> parts_;
  RandomStream random_;
  double sum_{};
};

}  // namespace gyrotherm
