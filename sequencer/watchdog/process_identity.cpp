#include "sequencer/watchdog/process_identity.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>
#include <utility>

#include "core/clock.hpp"
#include "drivers/line/descriptor.hpp"

namespace gyrotherm {

namespace {

struct Seen {
  ProcessIdentity identity;
  bool ended = false;  ///< and only waits to be reaped, or for those of its threads that the kernel still holds
  bool stopped = false;
};

/// proc(5): after the last ")" come the state (field 3) and, as field 22, the start.
std::optional<Seen> see(std::int64_t pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  std::string stat;
  std::getline(file, stat, '\0');  // nothing if it ends in between, of which a streambuf makes an exception
  const auto name_ends = stat.rfind(')');
  if (name_ends == std::string::npos) return {};
  std::istringstream fields(stat.substr(name_ends + 1));
  std::string state, skipped;
  fields >> state;
  constexpr int kFieldsBetween = 18;
  for (int i = 0; i < kFieldsBetween; ++i) fields >> skipped;
  Seen found{.identity = {.pid = pid, .started = 0, .boot = boot_id()},
             .ended = state == "Z" || state == "X",
             .stopped = state == "T" || state == "t"};
  if (!(fields >> found.identity.started)) return {};
  return found;
}

/// A handle of the process; closed if it is no more.
Descriptor handle_of(const ProcessIdentity& process) {
  Descriptor handle(static_cast<int>(::syscall(SYS_pidfd_open, static_cast<pid_t>(process.pid), 0)));
  // Compared after the handle is there: from now on the number cannot pass to another process.
  const auto found = see(process.pid);
  return found && found->identity == process ? std::move(handle) : Descriptor();
}

/// pidfd_open(2): readable once the process and all of its threads have ended.
bool ends(const Descriptor& handle, Duration within) {
  pollfd end{handle.number(), POLLIN, 0};
  return !handle.is_open() || ::poll(&end, 1, static_cast<int>(within / std::chrono::milliseconds(1))) > 0;
}

}  // namespace

std::optional<ProcessIdentity> identity_of(std::int64_t pid) {
  const auto found = see(pid);
  return found && !found->ended ? std::optional(found->identity) : std::nullopt;
}

ProcessIdentity own_identity() {
  return identity_of(::getpid()).value_or(ProcessIdentity{.pid = ::getpid(), .started = 0, .boot = {}});
}

bool lives(const ProcessIdentity& process) { return identity_of(process.pid) == process; }

bool is_stopped(std::int64_t pid) {
  const auto found = see(pid);
  return found && found->stopped;
}

bool ends(const ProcessIdentity& process, Duration within) { return ends(handle_of(process), within); }

bool kill_surely(const ProcessIdentity& process, Duration within) {
  const auto handle = handle_of(process);
  if (handle.is_open()) ::syscall(SYS_pidfd_send_signal, handle.number(), SIGKILL, nullptr, 0);
  return ends(handle, within);
}

}  // namespace gyrotherm
