#include "app/standard_input.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "app/interrupt.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kMost = 1 << 20;
constexpr int kUntilAWord = -1;

/// True if a read would not wait: there is input, or its end, or a fault. False too once a stop is asked for.
bool ready(int timeout_ms) {
  std::array<pollfd, 2> waits{{{STDIN_FILENO, POLLIN, 0}, {interrupt_descriptor(), POLLIN, 0}}};
  while (::poll(waits.data(), waits.size(), timeout_ms) < 0) {
    if (errno != EINTR || interrupted()) return false;
  }
  return waits[0].revents != 0 && !interrupted();
}

}  // namespace

Result<std::string_view> StandardInput::next() {
  buffer_.resize(kMost);
  std::size_t taken = 0;
  for (int timeout_ms = kUntilAWord; taken < kMost && ready(timeout_ms); timeout_ms = 0) {
    const ssize_t count = ::read(STDIN_FILENO, buffer_.data() + taken, kMost - taken);
    if (count == 0) break;
    if (count > 0) {
      taken += static_cast<std::size_t>(count);
    } else if (errno != EINTR && errno != EAGAIN) {
      return failure(FaultKind::storage, "stdin", std::strerror(errno));
    }
  }
  return std::string_view(buffer_.data(), taken);
}

}  // namespace gyrotherm
