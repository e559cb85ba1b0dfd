// SPDX-License-Identifier: Apache-2.0
#include "core/clock.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <time.h>

#include <fstream>

namespace gyrotherm {

/// CLOCK_BOOTTIME includes suspended time; std::chrono::steady_clock excludes it on Linux.
Duration since_boot() {
  timespec time{};
  ::clock_gettime(CLOCK_BOOTTIME, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

std::string boot_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  file >> id;
  return id;
}

SteadyClock::SteadyClock(Duration elapsed) : origin_(since_boot() - elapsed) {}

Instant SteadyClock::now() const {
  return {since_boot() - origin_, std::chrono::system_clock::now().time_since_epoch()};
}

Instant VirtualClock::now() const { return {elapsed_, kVirtualEpoch + epoch_offset_ + elapsed_}; }

std::string civil_time(Duration utc) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(utc).count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::string format_duration(Duration d) {
  const auto s = std::chrono::round<std::chrono::seconds>(d).count();
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min {:02} s", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace gyrotherm
