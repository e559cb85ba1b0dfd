// SPDX-License-Identifier: Apache-2.0
/// Executes a profile in virtual time, one second at a time. All tests of whole runs use it, with a bench rig, a
/// simulated plant or a virtual rig behind sockets.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

#include "acquisition/record/store.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/run/run_controller.hpp"

namespace gyrotherm::tests {

class RunHarness {
 public:
  /// `rig` and `store` must outlive the object, and the rig must be prepared.
  RunHarness(const profile::Profile& profile, rig::Rig& rig, record::Store& store)
      : rig_(rig), run_controller_(profile, rig, store, begin(profile), 0) {}

  [[nodiscard]] run::RunController& run_controller() { return run_controller_; }
  [[nodiscard]] const run::RunController& run_controller() const { return run_controller_; }
  [[nodiscard]] run::RunOutcome outcome() const { return outcome_; }
  [[nodiscard]] ProfilePosition progress() const {
    return profile_position(run_controller_.profile(), run_controller_.state());
  }

  /// Called before the time of a slot advances.
  std::function<void(std::int64_t slot)> before_second = {};
  std::function<void()> after_tick = {};

  /// Advances by `count` seconds with one tick each. Stops early when the run has ended. Returns the outcome of the
  /// last tick.
  run::RunOutcome seconds(std::int64_t count) {
    for (; count > 0 && outcome_ == run::RunOutcome::going_on; --count) {
      if (before_second) before_second(slot_);
      rig_.let_pass(1);
      const auto outcome = run_controller_.tick(slot_++);
      EXPECT_TRUE(outcome) << (outcome ? "" : text(outcome.error()));
      outcome_ = outcome.value_or(run::RunOutcome::stopped);
      if (after_tick) after_tick();
    }
    return outcome_;
  }
  /// Advances without a tick, as if the program was late or the machine was suspended.
  void without_tick(std::int64_t count) {
    rig_.let_pass(count);
    slot_ += count;
  }
  /// Advances until the condition is true. Returns the number of seconds, or −1 if it is still false after `most`.
  int until(const std::function<bool()>& condition, int most) {
    for (int i = 0; i <= most; ++i) {
      if (condition()) return i;
      seconds(1);
    }
    return -1;
  }
  int until(RunState state, int most) {
    return until([&] { return run_controller_.run_state() == state; }, most);
  }

 private:
  rig::Rig& rig_;
  run::RunController run_controller_;
  std::int64_t slot_ = 0;
  run::RunOutcome outcome_ = run::RunOutcome::going_on;
};

}  // namespace gyrotherm::tests
