#include "app/guard/process_identity.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/clock.hpp"
#include "drivers/line/descriptor.hpp"

namespace gyrotherm {

/// proc(5): after the last ")" come the state (field 3) and, as field 22, the start.
std::optional<ProcessIdentity> identity_of(std::int64_t pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  const std::string stat((std::istreambuf_iterator<char>(file)), {});
  const auto name_ends = stat.rfind(')');
  if (name_ends == std::string::npos) return {};
  std::istringstream fields(stat.substr(name_ends + 1));
  std::string state, skipped;
  fields >> state;
  if (state == "Z" || state == "X") return {};
  constexpr int kFieldsBetween = 18;
  for (int i = 0; i < kFieldsBetween; ++i) fields >> skipped;
  ProcessIdentity found{.pid = pid, .started = 0, .boot = boot_id()};
  if (!(fields >> found.started)) return {};
  return found;
}

ProcessIdentity own_identity() {
  return identity_of(::getpid()).value_or(ProcessIdentity{.pid = ::getpid(), .started = 0, .boot = {}});
}

bool lives(const ProcessIdentity& process) { return identity_of(process.pid) == process; }

bool kill_surely(const ProcessIdentity& process, Duration within) {
  const Descriptor handle(static_cast<int>(::syscall(SYS_pidfd_open, static_cast<pid_t>(process.pid), 0)));
  // Compared after the handle is there: from now on the number cannot pass to another process.
  if (!handle.is_open() || !lives(process)) return true;
  ::syscall(SYS_pidfd_send_signal, handle.number(), SIGKILL, nullptr, 0);
  pollfd end{handle.number(), POLLIN, 0};
  return ::poll(&end, 1, static_cast<int>(within / std::chrono::milliseconds(1))) > 0;
}

}  // namespace gyrotherm
