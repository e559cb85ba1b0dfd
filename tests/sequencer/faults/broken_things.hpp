// SPDX-License-Identifier: Apache-2.0
/// Faults of the virtual rig, one at a time: in an instrument, on a line, on the disk, in the clock.
#pragma once

#include <ostream>
#include <vector>

#include "tests/sequencer/faults/breakable_run.hpp"

namespace gyrotherm::faults {

/// One fault, and the reaction that docs/interlocks.md documents.
struct BrokenThing {
  const char* name;
  interlocks::InterlockId cause;
  interlocks::Reaction reaction;
  /// Second in which it breaks.
  int at;
  void (*breaks)(BreakableRun&);
  int acts_within;  ///< seconds
  /// Null if the fault passes by itself.
  void (*repairs)(BreakableRun&) = {};
  /// Seconds after the repair.
  int clears_within = 60;
  Setting setting = {};
  /// The set point moves back to its value before the fault.
  bool returns_to_set_point = false;
  /// Milder interlocks that also act, earlier or in the same second.
  std::vector<interlocks::InterlockId> also = {};
  /// The alarm remains until the end of the run.
  bool is_permanent = false;
};
inline std::ostream& operator<<(std::ostream& out, const BrokenThing& thing) { return out << thing.name; }

/// Returns the faults, at least one for each interlock.
[[nodiscard]] const std::vector<BrokenThing>& broken_things();

}  // namespace gyrotherm::faults
