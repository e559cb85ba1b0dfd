// SPDX-License-Identifier: Apache-2.0
/// Wall time of each stage of a long command; kept apart from results, because it varies from run to run.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::app {

/// The most that the program has held so far.
[[nodiscard]] double peak_memory_mb();

class Timings {
 public:
  /// Ends the stage before, if any.
  void begin(std::string stage);
  void end();
  /// Stages in order with their seconds, and the most memory that the program has held.
  [[nodiscard]] std::string to_json() const;
  [[nodiscard]] std::string words() const;

 private:
  std::vector<std::pair<std::string, double>> stages_;
  std::chrono::steady_clock::time_point began_{};
  bool running_ = false;
};

}  // namespace gyrotherm::app
