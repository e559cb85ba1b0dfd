// SPDX-License-Identifier: Apache-2.0
/// Measures how long a thread sleeps, independent of the load of the machine. Sleep is the time in which the thread
/// waits for a lock, a timer or a device. Time in which it works or waits for a processor does not count.
#pragma once

#include <chrono>
#include <cstdint>
#include <ctime>
#include <fstream>

namespace gyrotherm::tests {

/// Measures the calling thread from the construction on. Waits for a processor come from the kernel
/// (CONFIG_SCHED_INFO). A kernel without this option includes them in the sleep.
class SleepMeter {
 public:
  [[nodiscard]] std::chrono::nanoseconds slept() const {
    const auto now = awake_time();
    return std::chrono::steady_clock::now() - began_ - (now - awake_);
  }

 private:
  /// Returns the time in which this thread has worked or waited for a processor since its start.
  static std::chrono::nanoseconds awake_time() {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    std::int64_t worked_ns = 0, waited_ns = 0;
    std::ifstream("/proc/thread-self/schedstat") >> worked_ns >> waited_ns;
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec + waited_ns);
  }

  std::chrono::nanoseconds awake_ = awake_time();
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace gyrotherm::tests
