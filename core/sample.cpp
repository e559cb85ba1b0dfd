#include "core/sample.hpp"

namespace gyrotherm {

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
  }
  return "unknown";
}

}  // namespace gyrotherm
