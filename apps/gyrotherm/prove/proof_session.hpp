// SPDX-License-Identifier: Apache-2.0
/// Carries out the proof tests of a rig one after the other, and leaves the chamber as it was found.
#pragma once

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "core/result.hpp"
#include "sequencer/prove/proof.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

struct ProofOrder {
  const rig::RigFile& rig;
  std::vector<prove::ProofTest> tests;
  std::string operator_name;
  /// Folder of the protocol, which exists.
  std::string folder;
};

/// Carries out the tests. Stops at the first Ctrl-C; the chamber is restored even then. Fails before anything moves: if
/// the chamber is in use or does not answer, if it is in a state that would be lost, or if its relay is open.
[[nodiscard]] Result<prove::Proof> carry_out_proofs(Console& console, const ProofOrder& order);

/// Closes the relay of [safe.also] after the person has confirmed it. Fails with usage if the rig has none or no person
/// can answer, with interrupted if it was not confirmed, and as switch_relay() does.
[[nodiscard]] Result<void> close_relay_by_person(Console& console, const rig::RigFile& rig);

}  // namespace gyrotherm::app
