// SPDX-License-Identifier: Apache-2.0
#include "core/sample.hpp"

namespace gyrotherm {

const char* name(ChamberActivity activity) {
  switch (activity) {
    case ChamberActivity::unknown: return "unknown";
    case ChamberActivity::off: return "off";
    case ChamberActivity::running: return "running";
    case ChamberActivity::program: return "program";
    case ChamberActivity::ramping: return "ramping";
    case ChamberActivity::soaking: return "soaking";
    case ChamberActivity::waiting: return "waiting";
    case ChamberActivity::holding: return "holding";
    case ChamberActivity::done: return "done";
    case ChamberActivity::alarm: return "alarm";
    case ChamberActivity::door_open: return "door open";
    case ChamberActivity::emergency_stop: return "emergency stop";
    case ChamberActivity::power_failure: return "power failure";
  }
  return "unknown";
}

const char* name(Phase phase) {
  switch (phase) {
    case Phase::ramping: return "ramping";
    case Phase::holding: return "holding";
    case Phase::waiting_for_soak: return "waiting for soak";
    case Phase::overdue: return "overdue";
    case Phase::complete: return "complete";
  }
  return "unknown";
}

const char* name(RunState state) {
  switch (state) {
    case RunState::execute: return "execute";
    case RunState::suspended: return "suspended";
    case RunState::held: return "held";
    case RunState::aborting: return "aborting";
    case RunState::aborted: return "aborted";
    case RunState::stopped: return "stopped";
    case RunState::complete: return "complete";
  }
  return "unknown";
}

const char* name(EventKind kind) {
  switch (kind) {
    case EventKind::started: return "started";
    case EventKind::resumed: return "resumed";
    case EventKind::segment: return "segment";
    case EventKind::fault: return "fault";
    case EventKind::recovered: return "recovered";
    case EventKind::interlock: return "interlock";
    case EventKind::note: return "note";
    case EventKind::interrupted: return "interrupted";
    case EventKind::finished: return "finished";
    case EventKind::state: return "state";
    case EventKind::command: return "command";
  }
  return "unknown";
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
