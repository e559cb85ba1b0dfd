// SPDX-License-Identifier: Apache-2.0
/// The proof test of the interlocks: with the limits and the policy of a rig, each must act on injected readings, with
/// the reaction of the rig, and not before. No instrument is used.
#pragma once

#include <string>
#include <vector>

#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/prove/drill.hpp"
#include "sequencer/prove/proof.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::prove {

/// The outcome for one interlock.
struct InterlockOutcome {
  interlocks::InterlockId id{};
  /// Seconds with injected readings until it acted; 0: not tested.
  int seconds{};
  interlocks::Reaction reaction{};
  std::string cause{};    ///< cause of a failure; empty: none
  std::string omitted{};  ///< why it was not tested; empty: it was
};

/// Tests every interlock with the settings of the rig, in the order of their names.
[[nodiscard]] std::vector<InterlockOutcome> inject_all(const rig::RigFile& rig);

[[nodiscard]] ProofResult prove_interlocks(const rig::RigFile& rig, const DrillEnvironment& environment);

}  // namespace gyrotherm::prove
