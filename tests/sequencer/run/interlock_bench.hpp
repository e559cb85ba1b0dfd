// SPDX-License-Identifier: Apache-2.0
/// Runs the interlocks without a rig. For each second a test sets the sample, then reads the demands and alarms.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sequencer/interlocks/interlocks.hpp"

namespace gyrotherm::run {

/// A rig without faults, one second per step. A fault that the test sets remains.
class InterlockBench {
 public:
  InterlockBench() {
    sample.chamber = {ChamberState{{20}, {20}}, {}};
    sample.thermometers.assign(9, {Celsius{22}, {}});
    sample.units = {{.count = {GyroCount{{106}, kSecond}, {}}}};
    around.sent = Celsius{20};
  }

  ChamberState& chamber() { return *sample.chamber.value; }
  void thermometer(std::size_t i, double celsius) { sample.thermometers[i].value = Celsius{celsius}; }

  interlocks::InterlockDemand second(Duration elapsed = kSecond) {
    sample.at.since_start += elapsed;
    sample.at.utc += elapsed;
    auto result = judge(limits, std::move(memory), sample, elapsed, around);
    memory = std::move(result.memory);
    alarms += static_cast<int>(result.raised.size());
    for (const auto& alarm : result.raised) raised.emplace_back(std::string(name(alarm.id)) + " " + alarm.subject);
    for (const auto& alarm : result.cleared) cleared.emplace_back(std::string(name(alarm.id)) + " " + alarm.subject);
    over += static_cast<int>(result.cleared.size());
    return result.demand;
  }
  interlocks::InterlockDemand seconds(int count) {
    interlocks::InterlockDemand demand;
    for (int i = 0; i < count; ++i) demand = second();
    return demand;
  }
  /// Returns the first second with this reaction, or −1 if none of the next `most` has it.
  int seconds_until(interlocks::Reaction reaction, int most = 4000) {
    for (int i = 1; i <= most; ++i)
      if (second().reaction == reaction) return i;
    return -1;
  }
  [[nodiscard]] bool has(interlocks::InterlockId cause) const { return memory.most_affected_watch(cause).raised; }

  interlocks::InterlockLimits limits;
  interlocks::InterlockMemory memory;
  Sample sample;
  interlocks::InterlockInputs around;
  int alarms = 0, over = 0;
  std::vector<std::string> raised, cleared;  ///< "disagreement C", in order
};

inline auto silence() { return failure(FaultKind::timeout, "instrument", "no reply in 500 ms"); }

}  // namespace gyrotherm::run
