#include "app/guard/guard.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>

namespace gyrotherm {
namespace {

constexpr auto kSlice = std::chrono::milliseconds(1000);

/// Whether something can be read within a slice; a signal does not count.
bool readable(int descriptor) {
  pollfd line{descriptor, POLLIN, 0};
  const auto end = std::chrono::steady_clock::now() + kSlice;
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    const int found = ::poll(&line, 1, left.count() < 0 ? 0 : static_cast<int>(left.count()));
    if (found >= 0 || errno != EINTR) return found > 0;
  }
}

}  // namespace

WatchEnd watch(int descriptor, const WatchLimits& limits) {
  Duration silent{}, allowed = limits.preparing;
  while (silent < allowed) {
    if (!readable(descriptor)) {
      silent += kSlice;
      continue;
    }
    char bytes[256];
    const auto count = ::read(descriptor, bytes, sizeof bytes);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count <= 0) return WatchEnd::closed;
    const char last = bytes[count - 1];
    if (last == kGoodBye) return WatchEnd::good_bye;
    silent = {};
    allowed = last == kPreparing ? limits.preparing : limits.silence;
  }
  return WatchEnd::silent;
}

}  // namespace gyrotherm
