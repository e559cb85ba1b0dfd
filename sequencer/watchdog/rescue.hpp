/// One attempt at a chamber whose program has gone, in a process that may hang, and with regard to whoever else has the
/// chamber by now.
#pragma once

#include <string>

#include "sequencer/watchdog/child_work.hpp"
#include "sequencer/watchdog/safe_attempt.hpp"

namespace gyrotherm {

struct Rescued {
  SafeStage reached{};
  std::string details;
  bool in_use{};     ///< another program has the chamber by now: nothing was tried
  bool is_driven{};  ///< … and drives it, and does not make it safe
};

/// Holds the chamber's lock meanwhile. Without it, it acts all the same, unless a program of this user or of root that
/// drives chambers or makes them safe has it by now, does not stand still, and is not the one that has gone: one that
/// is dying keeps its lock while it hangs in the disk, and a stranger who holds it must not keep a chamber hot. An
/// attempt that hangs is ended, after ten seconds or, once the chamber has shown the safe set point, after fifteen
/// more.
[[nodiscard]] Rescued attempt_once(const SafeState& safe_state, const SafeStateChamber& chamber, Voice& voice);

}  // namespace gyrotherm
