#include "sequencer/watchdog/guard.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>

#include "drivers/line/descriptor.hpp"

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

/// One byte; a fault if none comes before the deadline.
Result<char> take_byte(int descriptor, const Deadline& deadline) {
  char byte = 0;
  if (!ready(descriptor, POLLIN, deadline)) return failure(FaultKind::timeout, "guard", "its orders do not come");
  if (::read(descriptor, &byte, 1) == 1) return byte;
  return failure(FaultKind::disconnected, "guard", "its orders end");
}

/// Digits up to a line break.
Result<std::size_t> take_length(int descriptor, const Deadline& deadline) {
  constexpr std::size_t kLongest = 4'000'000, kMostDigits = 8;
  std::string digits;
  for (;;) {
    const auto byte = take_byte(descriptor, deadline);
    if (!byte) return failure(byte.error());
    if (*byte == '\n') break;
    digits += *byte;
    if (digits.size() > kMostDigits) break;
  }
  std::size_t length = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), length);
  if (error != std::errc() || end != digits.data() + digits.size() || length > kLongest)
    return failure(FaultKind::corrupted, "guard", "its orders have no length");
  return length;
}

void answer(int descriptor) {
  const char heard = kHeard;
  [[maybe_unused]] const auto sent = ::send(descriptor, &heard, 1, MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace

std::string safe_state_message(std::string_view safe_state_text) {
  return fmt::format("{}{}\n{}", kSafeStateFollows, safe_state_text.size(), safe_state_text);
}

Result<std::string> receive_safe_state(int descriptor, Duration within) {
  const Deadline deadline(within);
  const auto first = take_byte(descriptor, deadline);
  if (!first) return failure(first.error());
  if (*first != kSafeStateFollows) return failure(FaultKind::corrupted, "guard", "its orders begin otherwise");
  const auto length = take_length(descriptor, deadline);
  if (!length) return failure(length.error());
  std::string text(*length, '\0');
  for (std::size_t have = 0; have < text.size();) {
    if (!ready(descriptor, POLLIN, deadline)) return failure(FaultKind::timeout, "guard", "its orders do not end");
    const auto size = ::read(descriptor, text.data() + have, text.size() - have);
    if (size <= 0) return failure(FaultKind::disconnected, "guard", "its orders end too early");
    have += static_cast<std::size_t>(size);
  }
  return text;
}

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
    answer(descriptor);
    silent = {};
    allowed = last == kPreparing ? limits.preparing : limits.silence;
  }
  return WatchEnd::silent;
}

}  // namespace gyrotherm
