#include "core/clock.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace gyrotherm {

SteadyClock::SteadyClock(Duration already) : origin_(std::chrono::steady_clock::now() - already) {}

Instant SteadyClock::now() const {
  return {std::chrono::steady_clock::now() - origin_, std::chrono::system_clock::now().time_since_epoch()};
}

Instant VirtualClock::now() const { return {elapsed_, kVirtualEpoch + elapsed_}; }

std::string civil_time(Duration utc) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(utc).count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::string spoken(Duration d) {
  const auto s = std::chrono::round<std::chrono::seconds>(d).count();
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min {:02} s", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace gyrotherm
