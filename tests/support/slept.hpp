// SPDX-License-Identifier: Apache-2.0
/// Measures how long a thread sleeps, independent of the load: the time in which it waits for a lock, a timer or a
/// device, without the time in which it works or waits for a processor.
#pragma once

#include <chrono>
#include <cstdint>
#include <ctime>
#include <fstream>

namespace gyrotherm::tests {

/// Measures the calling thread. The kernel counts the waits for a processor (CONFIG_SCHED_INFO). Without that count,
/// they are counted as sleep.
class SleepMeter {
 public:
  [[nodiscard]] std::chrono::nanoseconds slept() const {
    const auto now = at_work();
    return std::chrono::steady_clock::now() - began_ - (now - at_work_);
  }

 private:
  /// Returns how long this thread has worked, or waited for a processor, since it began.
  static std::chrono::nanoseconds at_work() {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    std::int64_t worked_ns = 0, waited_ns = 0;
    std::ifstream("/proc/thread-self/schedstat") >> worked_ns >> waited_ns;
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec + waited_ns);
  }

  std::chrono::nanoseconds at_work_ = at_work();
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace gyrotherm::tests
