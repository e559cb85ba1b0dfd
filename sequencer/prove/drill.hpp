// SPDX-License-Identifier: Apache-2.0
/// Parts that all proof tests share: time, the person at the chamber, and the log of a test.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "sequencer/prove/proof.hpp"

namespace gyrotherm::prove {

/// The surroundings of a test.
struct DrillEnvironment {
  const Clock& clock;
  /// Lets time pass. The caller may send a heartbeat meanwhile.
  std::function<void(Duration)> wait;
  /// Returns true once the person wants to stop.
  std::function<bool()> is_interrupted;
  /// Asks the person to do something, and returns true once it is done. Returns false if the person refuses or stops.
  std::function<bool(const std::string& question)> ask;
  /// Shows the progress.
  std::function<void(const std::string& text)> say;
  /// Opens a new connection to the chamber. Some controllers accept only one client.
  std::function<std::unique_ptr<drivers::Chamber>()> connect;
};

/// Collects the readings of one test.
class DrillLog {
 public:
  DrillLog(ProofTest test, const DrillEnvironment& environment)
      : environment_(environment), began_(environment.clock.now()) {
    result_.test = test;
    result_.began = civil_time(began_.utc);
  }

  void limit(std::string what, std::string limit) { result_.limits.push_back({std::move(what), std::move(limit)}); }
  void read(std::string what, std::string value) {
    environment_.say(fmt::format("{}: {} {}", name(result_.test), what, value));
    result_.readings.push_back({passed_s(), std::move(what), std::move(value)});
  }
  [[nodiscard]] double passed_s() const {
    return to_seconds(environment_.clock.now().since_start - began_.since_start);
  }
  /// Ends the test.
  [[nodiscard]] ProofResult end(ProofVerdict verdict, std::string cause = "") {
    result_.verdict = verdict;
    result_.cause = std::move(cause);
    result_.duration_s = passed_s();
    return result_;
  }

 private:
  const DrillEnvironment& environment_;
  Instant began_;
  ProofResult result_;
};

/// Returns whether the chamber reports an alarm that stops a run.
[[nodiscard]] inline bool has_alarm(const ChamberState& state) {
  return state.must_stop || state.activity == ChamberActivity::alarm;
}
[[nodiscard]] inline std::string celsius_text(Celsius value) { return fmt::format("{:.2f} °C", value.value); }

}  // namespace gyrotherm::prove
