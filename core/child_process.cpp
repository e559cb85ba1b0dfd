// SPDX-License-Identifier: Apache-2.0
#include "core/child_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>
#include <utility>

#include "core/deadline.hpp"

namespace gyrotherm {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kTakesAllAddresses = true;
#else
constexpr bool kTakesAllAddresses = false;
#endif

void set_limit(int resource, rlim_t most) {
  rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return;
  limit.rlim_cur = std::min(most, limit.rlim_max);
  limit.rlim_max = limit.rlim_cur;
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

/// The address space that this process has, in bytes (proc(5), statm).
std::uint64_t address_space() {
  std::ifstream sizes("/proc/self/statm");
  std::uint64_t pages = 0;
  sizes >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Leaves the child nothing but its line to the parent, which gets a number of its own; returns that.
int leave_all_but(int to_parent) {
  constexpr int kLine = STDERR_FILENO + 1;
  if (const Descriptor nothing(::open("/dev/null", O_RDWR)); nothing.is_open())
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing.number(), stream);
  if (to_parent != kLine) ::dup2(to_parent, kLine);
  ::close_range(kLine + 1, ~0U, 0);
  return kLine;
}

/// Has these signals end the process, whatever the parent made of them.
void take_no_signals_of_parent() {
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGXCPU, SIGXFSZ, SIGPIPE}) ::signal(signal, SIG_DFL);
}

int confine(const Confinement& confinement, int to_parent) {
  take_no_signals_of_parent();
  std::set_new_handler([] { ::_exit(kNoMemoryLeft); });
  if (!kTakesAllAddresses && confinement.memory_bytes > 0)
    set_limit(RLIMIT_AS, address_space() + confinement.memory_bytes);
  const int line = leave_all_but(to_parent);
  set_limit(RLIMIT_FSIZE, 0);
  set_limit(RLIMIT_CORE, 0);
  return line;
}

}  // namespace

Pipe new_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return {};
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

void leave_parents_input() {
  const Descriptor nothing(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (nothing.is_open()) ::dup2(nothing.number(), STDIN_FILENO);
}

bool reap(pid_t pid, Duration within, int* status) {
  const Descriptor watched(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  if (watched.is_open()) [[maybe_unused]]
    const bool ended = ready(watched.number(), POLLIN, Deadline(within));
  return ::waitpid(pid, status, WNOHANG) != 0;
}

std::string ending_in_words(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("was ended by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

ChildProcess::ChildProcess(const std::function<void(int)>& work, const std::optional<Confinement>& confinement) {
  auto pipe = new_pipe();
  pid_ = pipe.from.is_open() ? ::fork() : -1;
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    leave_parents_input();
    work(confinement ? confine(*confinement, pipe.to.number()) : pipe.to.number());
    ::_exit(0);
  }
  output_ = std::move(pipe.from);
}

ChildProcess::~ChildProcess() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  [[maybe_unused]] const bool ended = reap(pid_, std::chrono::milliseconds(200));
}

std::optional<int> ChildProcess::wait(Duration within) {
  int status = 0;
  if (pid_ <= 0 || !reap(pid_, within, &status)) return std::nullopt;
  pid_ = 0;
  return status;
}

void allow_processor_time(std::chrono::seconds more) {
  rusage used{};
  rlimit limit{};
  if (::getrusage(RUSAGE_SELF, &used) != 0 || ::getrlimit(RLIMIT_CPU, &limit) != 0) return;
  limit.rlim_cur = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + 1 + more.count());
  ::setrlimit(RLIMIT_CPU, &limit);
}

}  // namespace gyrotherm
