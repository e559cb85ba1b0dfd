// SPDX-License-Identifier: Apache-2.0
/// Proof tests of the watchdog: a program that drives the chamber is killed, and the chamber must become safe; the same
/// while the line to the chamber is dead.
#pragma once

#include <chrono>
#include <string>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "sequencer/prove/drill.hpp"
#include "sequencer/prove/proof.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::prove {

/// Time within which the chamber shows the safe set point and mode after its program has died (docs/reliability.md).
inline constexpr Duration kStatedSafeTime = std::chrono::seconds(20);

/// Limits of the tests; other values are for tests of the tests.
struct GuardTimes {
  /// Time in which the chamber shows the set point of the program.
  Duration show = std::chrono::seconds(60);
  Duration safe = kStatedSafeTime;
  /// Time that the guard has for its trace after the air was observed.
  Duration confirm = std::chrono::seconds(60);
  /// Time beyond [safe.also] after in which the relay opens.
  Duration relay = std::chrono::seconds(12);
  /// Time for which the line stays dead without a relay: longer than one attempt of the guard.
  Duration dead_line = std::chrono::seconds(11);
};

/// Returns a set point that differs from the safe one by a few kelvins, within the chamber's limits. Fails with usage
/// if the limits leave no set point whose difference from the safe one can be seen.
[[nodiscard]] Result<Celsius> test_set_point(const rig::RigFile& rig);

/// Starts a program under its guard, kills it, and watches the chamber on a connection of its own. `record` is the path
/// on which the guard leaves its trace.
[[nodiscard]] ProofResult prove_make_safe(const rig::RigFile& rig, const std::string& record,
                                          const DrillEnvironment& environment, const GuardTimes& times = {});

/// Does the same through a line that is cut before the program is killed. With [safe.also], the guard must open the
/// relay; it is closed again once the chamber is safe. After the line has returned, the chamber must become safe. Does
/// not return before the guard has confirmed that, also after a failure; if it does not confirm it in time, the line
/// stays open for the guard.
[[nodiscard]] ProofResult prove_line(const rig::RigFile& rig, const std::string& record,
                                     const DrillEnvironment& environment, const GuardTimes& times = {});

/// Opens the relay of [safe.also], reads it back, and closes it.
[[nodiscard]] ProofResult prove_relay(const rig::RigFile& rig, const DrillEnvironment& environment);

/// Returns the reason why the relay is not closed; empty if it is, or if the rig has none. A run and the proof tests do
/// not start while there is a reason.
[[nodiscard]] std::string relay_refusal_reason(const rig::RigFile& rig, const std::string& rig_file);

}  // namespace gyrotherm::prove
