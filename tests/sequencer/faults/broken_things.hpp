// SPDX-License-Identifier: Apache-2.0
/// What breaks in the virtual rig, one thing at a time: in an instrument, on a line, on the disk, in the clock.
#pragma once

#include <ostream>
#include <vector>

#include "tests/sequencer/faults/breakable_run.hpp"

namespace gyrotherm::faults {

/// One thing that breaks, and what docs/interlocks.md says of it.
struct BrokenThing {
  const char* shows;
  interlocks::InterlockId cause;
  interlocks::Reaction reaction;
  int at;  ///< second in which it breaks
  void (*breaks)(BreakableRun&);
  int acts_within;                    ///< seconds
  void (*mends)(BreakableRun&) = {};  ///< nothing: it passes by itself
  int over_within = 60;               ///< seconds, once it is mended
  Setting setting = {};
  bool brought_back = false;                       ///< the set point is not left where it was found
  std::vector<interlocks::InterlockId> also = {};  ///< milder ones that it raises besides, earlier or at once
  bool for_good = false;                           ///< its alarm stands until the run ends
};
inline std::ostream& operator<<(std::ostream& out, const BrokenThing& thing) { return out << thing.shows; }

/// For each cause at least one.
[[nodiscard]] const std::vector<BrokenThing>& broken_things();

}  // namespace gyrotherm::faults
