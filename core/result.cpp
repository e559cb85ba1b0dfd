#include "core/result.hpp"

namespace gyrotherm {

const char* name(FaultKind kind) {
  switch (kind) {
    case FaultKind::timeout: return "timeout";
    case FaultKind::disconnected: return "disconnected";
    case FaultKind::refused: return "refused";
    case FaultKind::corrupted: return "corrupted";
    case FaultKind::out_of_range: return "out_of_range";
    case FaultKind::mismatch: return "mismatch";
    case FaultKind::interlock: return "interlock";
    case FaultKind::bad_file: return "bad_file";
    case FaultKind::storage: return "storage";
    case FaultKind::numeric: return "numeric";
    case FaultKind::interrupted: return "interrupted";
    case FaultKind::usage: return "usage";
  }
  return "unknown";
}

std::string text(const Fault& fault) { return fault.where.empty() ? fault.what : fault.where + ": " + fault.what; }

}  // namespace gyrotherm
