// SPDX-License-Identifier: Apache-2.0
/// The proof test of the chamber's own over-temperature limiter. A person sets it low; the chamber heats until it
/// trips.
#pragma once

#include <string>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "sequencer/prove/drill.hpp"
#include "sequencer/prove/proof.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::prove {

struct LimiterPlan {
  Celsius at;           ///< setting of the limiter during the test
  Celsius set_point;    ///< above it
  Celsius safe;         ///< set point after the test
  Kelvins band;         ///< permitted error of the trip
  Duration within;      ///< to the trip
  Duration hold;        ///< the limiter must stay tripped
  std::string usual{};  ///< its setting for runs, for the person
};
/// Plans the test for a chamber whose air is at `air`. Fails with usage if the rig's limits leave no room for it.
[[nodiscard]] Result<LimiterPlan> plan_limiter_proof(const rig::RigFile& rig, Celsius air);

/// Called around the time in which the chamber heats: the watchdog must be active. end_guarded() is called once the
/// chamber has shown its safe set point.
struct GuardedHeating {
  std::function<Result<void>()> begin;
  std::function<void()> end;
};

/// Carries out the test. Whatever happens after the set point was sent, it sends the safe set point and reads it back
/// before it returns; if the chamber does not answer, it returns without GuardedHeating::end, so the watchdog acts.
[[nodiscard]] ProofResult prove_limiter(const LimiterPlan& plan, const GuardedHeating& guarded,
                                        const DrillEnvironment& environment);

}  // namespace gyrotherm::prove
