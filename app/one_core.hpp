/// Both ends of a loopback exchange on one processor: a virtual run makes a million of them, and waking another core
/// costs most.
#pragma once

#include <sched.h>

namespace gyrotherm {

/// While it lives, the calling thread (and every thread it starts) stays on the processor it is on now. Where the
/// system does not allow it, nothing happens.
class OneCore {
 public:
  OneCore();
  ~OneCore();
  OneCore(const OneCore&) = delete;
  OneCore& operator=(const OneCore&) = delete;

 private:
  cpu_set_t before_{};
  bool pinned_ = false;
};

}  // namespace gyrotherm
