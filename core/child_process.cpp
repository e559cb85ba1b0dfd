// SPDX-License-Identifier: Apache-2.0
#include "core/child_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>
#include <optional>
#include <utility>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/sanitizer.hpp"
#include "core/text.hpp"

namespace gyrotherm {
namespace {

void set_limit(int resource, rlim_t maximum) {
  rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return;
  limit.rlim_cur = std::min(maximum, limit.rlim_max);
  limit.rlim_max = limit.rlim_cur;
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

/// Returns the size of this process's address space in bytes (proc(5), statm).
std::uint64_t address_space() {
  std::ifstream sizes("/proc/self/statm");
  std::uint64_t pages = 0;
  sizes >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Closes every descriptor of the child except its pipe to the parent, and redirects the standard streams to /dev/null.
/// Moves the pipe to a new descriptor number and returns it.
int close_all_but_pipe(int to_parent) {
  constexpr int kPipeNumber = STDERR_FILENO + 1;
  if (const Descriptor nothing(::open("/dev/null", O_RDWR)); nothing.is_open())
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing.number(), stream);
  if (to_parent != kPipeNumber) ::dup2(to_parent, kPipeNumber);
  ::close_range(kPipeNumber + 1, ~0U, 0);
  return kPipeNumber;
}

/// Unblocks all signals and restores the default action of the signals that this program may ignore.
void reset_signals() {
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGXCPU, SIGXFSZ, SIGPIPE}) ::signal(signal, SIG_DFL);
}

int confine(const Confinement& confinement, int to_parent) {
  reset_signals();
  std::set_new_handler([] { ::_exit(kOutOfMemoryExitCode); });
  if (!kIsSanitizerBuild && confinement.memory_bytes > 0)
    set_limit(RLIMIT_AS, address_space() + confinement.memory_bytes);
  const int pipe_number = close_all_but_pipe(to_parent);
  set_limit(RLIMIT_FSIZE, 0);
  set_limit(RLIMIT_CORE, 0);
  return pipe_number;
}

}  // namespace

Pipe new_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return {};
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

void detach_standard_input() {
  const Descriptor nothing(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (nothing.is_open()) ::dup2(nothing.number(), STDIN_FILENO);
}

bool reap(pid_t pid, Duration within, int* status) {
  const Descriptor watched(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  if (watched.is_open()) [[maybe_unused]]
    const bool ended = wait_until_ready(watched.number(), POLLIN, Deadline(within));
  return ::waitpid(pid, status, WNOHANG) != 0;
}

std::string describe_exit_status(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("was ended by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

ChildProcess::ChildProcess(const std::function<void(int)>& work, const std::optional<Confinement>& confinement) {
  auto pipe = new_pipe();
  pid_ = pipe.from.is_open() ? ::fork() : -1;
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    detach_standard_input();
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

void limit_processor_time(std::chrono::seconds more) {
  rusage used{};
  rlimit limit{};
  if (::getrusage(RUSAGE_SELF, &used) != 0 || ::getrlimit(RLIMIT_CPU, &limit) != 0) return;
  limit.rlim_cur = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + 1 + more.count());
  ::setrlimit(RLIMIT_CPU, &limit);
}

namespace {

constexpr mode_t kLogFileMode = 0640;

class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }

  void open(int number, const char* path, int flags) {
    posix_spawn_file_actions_addopen(&actions_, number, path, flags, kLogFileMode);
  }
  void copy(int from, int to) { posix_spawn_file_actions_adddup2(&actions_, from, to); }
  void change_folder(const std::string& folder) { posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str()); }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

Result<pid_t> spawn(const std::vector<std::string>& command, const FileActions& files, bool has_own_group = false) {
  std::vector<char*> words;
  for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));  // execve() requires it
  words.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  // The process group 0 stands for one with the number of the child.
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           static_cast<short>(POSIX_SPAWN_SETSIGMASK | (has_own_group ? POSIX_SPAWN_SETPGROUP : 0)));
  pid_t child{};
  const int code = ::posix_spawnp(&child, words.front(), files.get(), &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (code != 0) return failure(FaultKind::refused, command.front(), std::strerror(code));
  return child;
}

/// Output of a program on stdout and stderr.
struct ProgramOutput {
  std::string output, errors;
  [[nodiscard]] std::size_t size() const { return output.size() + errors.size(); }
};

/// Appends the available bytes to `text`. Returns false at the end of the pipe.
bool read_available(int number, std::string& text) {
  std::array<char, 4096> piece;
  const auto got = read_some(number, piece.data(), piece.size());
  if (got > 0) text.append(piece.data(), static_cast<std::size_t>(got));
  return got > 0;
}

/// Reads both pipes to their ends, or until they had more than `max_bytes`. Returns nothing if the deadline passes
/// first.
std::optional<ProgramOutput> read_both_pipes(int output, int errors, const Deadline& deadline, std::size_t max_bytes) {
  ProgramOutput printed;
  std::array lines{pollfd{output, POLLIN, 0}, pollfd{errors, POLLIN, 0}};  // poll() skips negative descriptors
  const std::array texts{&printed.output, &printed.errors};
  while ((lines[0].fd >= 0 || lines[1].fd >= 0) && printed.size() <= max_bytes) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline.left()).count();
    const int found = ::poll(lines.data(), lines.size(), static_cast<int>(left));
    if (found < 0 && errno == EINTR) continue;
    if (found <= 0) return std::nullopt;
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (lines[i].revents != 0 && !read_available(lines[i].fd, *texts[i])) lines[i].fd = kNoDescriptor;
  }
  return printed;
}

}  // namespace

Result<pid_t> start(const std::vector<std::string>& command, const LaunchSettings& in) {
  FileActions files;
  files.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  if (!in.log.empty()) {
    files.open(STDERR_FILENO, in.log.c_str(), O_WRONLY | O_CREAT | O_APPEND);
    files.copy(STDERR_FILENO, STDOUT_FILENO);
  }
  if (!in.output.empty()) files.open(STDOUT_FILENO, in.output.c_str(), O_WRONLY | O_CREAT | O_TRUNC);
  if (!in.folder.empty()) files.change_folder(in.folder);
  return spawn(command, files, in.has_own_group);
}

namespace {

/// Returns the exit code, or 128 plus the number of the signal, as shells do.
int shell_exit_code(int status) {
  constexpr int kSignalOffset = 128;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalOffset + WTERMSIG(status);
}

}  // namespace

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return shell_exit_code(status);
}

Result<int> run_and_wait(const std::vector<std::string>& command, const LaunchSettings& in) {
  return start(command, in).map(wait_for);
}

Result<std::string> read_program_output(const std::vector<std::string>& command, Duration within,
                                        std::size_t max_bytes) {
  auto output = new_pipe(), errors = new_pipe();
  if (!output.from.is_open() || !errors.from.is_open())
    return failure(FaultKind::refused, command.front(), std::strerror(errno));
  FileActions files;
  files.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  files.copy(output.to.number(), STDOUT_FILENO);
  files.copy(errors.to.number(), STDERR_FILENO);
  const auto child = spawn(command, files);
  if (!child) return failure(child.error());
  output.to.close();
  errors.to.close();
  const Deadline deadline(within);
  auto printed = read_both_pipes(output.from.number(), errors.from.number(), deadline, max_bytes);
  const bool is_too_long = printed && printed->size() > max_bytes;
  int status = 0;
  // A program may close its output and continue.
  if (!printed || is_too_long || !reap(*child, deadline.left(), &status)) {
    ::kill(*child, SIGKILL);
    (void)wait_for(*child);
    if (is_too_long)
      return failure(FaultKind::refused, command.front(), fmt::format("printed more than {} bytes", max_bytes));
    return failure(FaultKind::timeout, command.front(), "did not end in time");
  }
  const int code = shell_exit_code(status);
  if (code != 0)
    return failure(FaultKind::refused, fmt::format("{}", fmt::join(command, " ")),
                   fmt::format("ended with {}: {}", code,
                               trimmed(printed->errors.empty() ? printed->output : printed->errors, " \n")));
  return std::move(printed->output);
}

}  // namespace gyrotherm
