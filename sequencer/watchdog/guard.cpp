// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/guard.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <utility>

#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"

namespace gyrotherm::watchdog {

namespace {

struct ProcessState {
  ProcessIdentity identity;
  /// The process has ended, and only waits to be reaped or for threads that the kernel still holds.
  bool ended = false;
  bool stopped = false;
};

/// Reads proc(5): after the last ")" come the state (field 3) and, as field 22, the start.
std::optional<ProcessState> read_process(std::int64_t pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  // Reads nothing if the process ends now: a streambuf throws in that case.
  std::string stat;
  std::getline(file, stat, '\0');
  const auto name_ends = stat.rfind(')');
  if (name_ends == std::string::npos) return {};
  std::istringstream fields(stat.substr(name_ends + 1));
  std::string state, skipped;
  fields >> state;
  constexpr int kFieldsBetween = 18;
  for (int i = 0; i < kFieldsBetween; ++i) fields >> skipped;
  ProcessState found{.identity = {.pid = pid, .started = 0, .boot = boot_id()},
                     .ended = state == "Z" || state == "X",
                     .stopped = state == "T" || state == "t"};
  if (!(fields >> found.identity.started)) return {};
  return found;
}

/// Returns a handle of the process; closed if the process has ended.
Descriptor open_handle(const ProcessIdentity& process) {
  Descriptor handle(static_cast<int>(::syscall(SYS_pidfd_open, static_cast<pid_t>(process.pid), 0)));
  // The identity is compared after the handle is open: from then on, no other process can get the number.
  const auto found = read_process(process.pid);
  return found && found->identity == process ? std::move(handle) : Descriptor();
}

/// Waits for the end of the process and all of its threads: then the handle is readable, pidfd_open(2).
bool wait_for_end(const Descriptor& handle, Duration within) {
  pollfd end{handle.number(), POLLIN, 0};
  return !handle.is_open() || ::poll(&end, 1, static_cast<int>(within / std::chrono::milliseconds(1))) > 0;
}

}  // namespace

std::optional<ProcessIdentity> read_process_identity(std::int64_t pid) {
  const auto found = read_process(pid);
  return found && !found->ended ? std::optional(found->identity) : std::nullopt;
}

ProcessIdentity own_identity() {
  return read_process_identity(::getpid()).value_or(ProcessIdentity{.pid = ::getpid(), .started = 0, .boot = {}});
}

bool is_alive(const ProcessIdentity& process) { return read_process_identity(process.pid) == process; }

bool is_stopped(std::int64_t pid) {
  const auto found = read_process(pid);
  return found && found->stopped;
}

bool wait_for_end(const ProcessIdentity& process, Duration within) {
  return wait_for_end(open_handle(process), within);
}

bool kill_process(const ProcessIdentity& process, Duration within) {
  const auto handle = open_handle(process);
  if (handle.is_open()) ::syscall(SYS_pidfd_send_signal, handle.number(), SIGKILL, nullptr, 0);
  return wait_for_end(handle, within);
}

namespace {

constexpr auto kMaxWait = std::chrono::milliseconds(1000);

/// Returns true if the descriptor becomes readable within kMaxWait. A signal does not end the wait.
bool is_readable(int descriptor) { return wait_until_ready(descriptor, POLLIN, Deadline(kMaxWait)); }

/// Reads one byte. Fails if none arrives before the deadline.
Result<char> read_byte(int descriptor, const Deadline& deadline) {
  char byte = 0;
  if (!wait_until_ready(descriptor, POLLIN, deadline))
    return failure(FaultKind::timeout, "guard", "no instructions received in time");
  if (::read(descriptor, &byte, 1) == 1) return byte;
  return failure(FaultKind::disconnected, "guard", "connection closed before the instructions arrived");
}

/// Reads digits up to a line break.
Result<std::size_t> read_length(int descriptor, const Deadline& deadline) {
  constexpr std::size_t kMaxLength = 4'000'000, kMaxDigits = 8;
  std::string digits;
  for (;;) {
    const auto byte = read_byte(descriptor, deadline);
    if (!byte) return failure(byte.error());
    if (*byte == '\n') break;
    digits += *byte;
    if (digits.size() > kMaxDigits) break;
  }
  std::size_t length = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), length);
  if (error != std::errc() || end != digits.data() + digits.size() || length > kMaxLength)
    return failure(FaultKind::corrupted, "guard", "the instructions have an invalid length");
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
  const auto first = read_byte(descriptor, deadline);
  if (!first) return failure(first.error());
  if (*first != kSafeStateFollows)
    return failure(FaultKind::corrupted, "guard", "the instructions begin with an unexpected byte");
  const auto length = read_length(descriptor, deadline);
  if (!length) return failure(length.error());
  std::string text(*length, '\0');
  for (std::size_t have = 0; have < text.size();) {
    if (!wait_until_ready(descriptor, POLLIN, deadline))
      return failure(FaultKind::timeout, "guard", "the instructions are incomplete");
    const auto size = ::read(descriptor, text.data() + have, text.size() - have);
    if (size <= 0)
      return failure(FaultKind::disconnected, "guard", "connection closed before the end of the instructions");
    have += static_cast<std::size_t>(size);
  }
  return text;
}

WatchEnd watch(int descriptor, const WatchLimits& limits) {
  Duration silent{}, allowed = limits.preparing;
  while (silent < allowed) {
    if (!is_readable(descriptor)) {
      silent += kMaxWait;
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

}  // namespace gyrotherm::watchdog
