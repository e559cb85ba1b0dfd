// SPDX-License-Identifier: Apache-2.0
#include "core/sample.hpp"

namespace gyrotherm {

const char* name(ChamberActivity activity) {
  return word_in<ChamberActivity::power_failure>(
      {"unknown", "off", "running", "program", "ramping", "soaking", "waiting", "holding", "done", "alarm", "door open",
       "emergency stop", "power failure"},
      activity);
}

const char* name(Phase phase) {
  return word_in<Phase::complete>({"ramping", "holding", "waiting for soak", "overdue", "complete"}, phase);
}

const char* name(RunState state) {
  return word_in<RunState::complete>({"execute", "suspended", "held", "aborting", "aborted", "stopped", "complete"},
                                     state);
}

const char* name(EventKind kind) {
  return word_in<EventKind::command>({"started", "resumed", "segment", "fault", "recovered", "interlock", "note",
                                      "interrupted", "finished", "state", "command"},
                                     kind);
}

bool carries_out_program(ChamberActivity activity) {
  switch (activity) {
    case ChamberActivity::program:
    case ChamberActivity::ramping:
    case ChamberActivity::soaking:
    case ChamberActivity::waiting:
    case ChamberActivity::holding: return true;
    default: return false;
  }
}

}  // namespace gyrotherm
