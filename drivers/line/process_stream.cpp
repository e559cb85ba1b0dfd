// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/process_stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <optional>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "drivers/line/pauses.hpp"

namespace gyrotherm::drivers {
namespace {

namespace fs = std::filesystem;

constexpr Duration kEndTimeout = std::chrono::milliseconds(500), kKillTimeout = std::chrono::seconds(1);
/// After this time, the start of a program counts as successful.
constexpr Duration kSettlingTime = std::chrono::seconds(10);
constexpr std::size_t kMaxLastLine = 200;  ///< bytes quoted in a message

std::string describe_exit(int status) {
  if (WIFSIGNALED(status)) return fmt::format("the program was terminated by signal {}", WTERMSIG(status));
  return fmt::format("the program ended with exit code {}", WEXITSTATUS(status));
}

/// Both ends of the socket pair for stdin and stdout, and both ends of the pipe for stderr.
struct Pipes {
  Descriptor our_data, child_data, our_errors, child_errors;
};

Result<Pipes> make_pipes(const std::string& place) {
  std::array<int, 2> both{}, errors{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, both.data()) != 0)
    return failure(FaultKind::disconnected, place, std::strerror(errno));
  Pipes pipes{.our_data = Descriptor(both[0]), .child_data = Descriptor(both[1]), .our_errors = {}, .child_errors = {}};
  if (::pipe2(errors.data(), O_CLOEXEC) != 0) return failure(FaultKind::disconnected, place, std::strerror(errno));
  pipes.our_errors = Descriptor(errors[0]);
  pipes.child_errors = Descriptor(errors[1]);
  for (const int end : {pipes.our_data.number(), pipes.our_errors.number()}) ::fcntl(end, F_SETFL, O_NONBLOCK);
  return pipes;
}

/// Starts the program. Returns its process number, or 0 with errno set.
pid_t spawn(const ProgramCommand& command, const Pipes& pipes) {
  std::vector<char*> words;
  for (const auto& word : command.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addchdir_np(&files, command.folder.c_str());
  posix_spawn_file_actions_adddup2(&files, pipes.child_data.number(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, pipes.child_data.number(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, pipes.child_errors.number(), STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, pipes_end;
  sigemptyset(&none);
  sigemptyset(&pipes_end);
  sigaddset(&pipes_end, SIGPIPE);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &pipes_end);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, words.front(), &files, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  errno = error;
  return error == 0 ? child : 0;
}

}  // namespace

std::string text(const ProgramCommand& command) { return fmt::format("{}", fmt::join(command.words, " ")); }

Result<std::string> find_program(const ProgramCommand& command) {
  const auto& word = command.words.front();
  if (word.find('/') != std::string::npos) {
    const std::string file = fs::path(command.folder) / word;  // absolute paths replace `folder`
    if (is_executable(file)) return file;
    return failure(FaultKind::disconnected, file, "is not a program that this user may run");
  }
  const auto file = find_program_in_path(word, command.folder);
  if (file.empty()) return failure(FaultKind::disconnected, word, "program not found in PATH");
  return file;
}

/// A running process, and our ends of its pipes.
class ProcessStream::Child {
 public:
  Child(pid_t process, Pipes& pipes)
      : process_(process),
        watched_(static_cast<int>(::syscall(SYS_pidfd_open, process, 0))),
        line_(std::move(pipes.our_data)),
        errors_(std::move(pipes.our_errors)) {}
  ~Child() { (void)kill(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  [[nodiscard]] int line() const { return line_.number(); }
  [[nodiscard]] bool is_settled() const { return settling_.has_passed(); }
  [[nodiscard]] bool is_running() const {
    return !watched_.is_open() || !wait_until_ready(watched_.number(), POLLIN, Deadline(Duration::zero()));
  }
  void close_and_wait(Duration within) {
    ::shutdown(line_.number(), SHUT_RDWR);
    if (watched_.is_open()) (void)wait_until_ready(watched_.number(), POLLIN, Deadline(within));
  }
  /// Kills the process group. Returns a description of how the process ended, with its last line on stderr. No other
  /// process can be killed, because a process number is not reused before waitpid().
  std::string kill() {
    if (process_ == 0) return {};
    ::kill(-process_, SIGKILL);
    ::kill(process_, SIGKILL);
    if (watched_.is_open()) (void)wait_until_ready(watched_.number(), POLLIN, Deadline(kKillTimeout));
    int status = 0;
    const bool dead = ::waitpid(process_, &status, WNOHANG) == process_;
    process_ = 0;
    read_errors();
    const auto last = last_line();
    return (dead ? describe_exit(status) : "the program was killed but has not ended yet") +
           (last.empty() ? last : fmt::format("; its last output was \"{}\"", last));
  }
  /// Waits for output of the program and returns true, or returns false at the deadline. Reads the program's stderr
  /// while waiting.
  [[nodiscard]] bool wait(const Deadline& deadline) {
    while (!deadline.has_passed()) {
      std::array<pollfd, 2> lines{{{line(), POLLIN, 0}, {errors_.number(), POLLIN, 0}}};
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline.left());
      const int found = ::poll(lines.data(), lines.size(), static_cast<int>(left.count()));
      if (lines[1].revents != 0) read_errors();
      if (lines[0].revents != 0) return true;
      if (found < 0 && errno != EINTR) return false;
    }
    return false;
  }
  /// Reads the available stderr output of the program, up to a limit, because the program would block on a full pipe.
  void read_errors() {
    constexpr int kMostPieces = 64;
    std::array<char, 4096> some{};
    for (int i = 0; i < kMostPieces && errors_.is_open(); ++i) {
      const auto size = ::read(errors_.number(), some.data(), some.size());
      if (size == 0) errors_.close();
      if (size <= 0) return;
      error_output_.append(some.data(), static_cast<std::size_t>(size));
      if (error_output_.size() > some.size()) error_output_.erase(0, error_output_.size() - some.size());
    }
  }

 private:
  [[nodiscard]] std::string last_line() const {
    auto whole = trimmed(error_output_, " \t\r\n");
    if (const auto end = whole.rfind('\n'); end != std::string_view::npos) whole.remove_prefix(end + 1);
    return plain(whole.substr(0, kMaxLastLine));
  }

  pid_t process_;
  Descriptor watched_, line_, errors_;
  Deadline settling_{kSettlingTime};
  std::string error_output_;
};

struct ProcessStream::State {
  ProgramCommand command;
  std::unique_ptr<Child> child{};
  Backoff backoff{};
};

ProcessStream::ProcessStream(ProgramCommand command)
    : state_(std::make_unique<State>(State{.command = std::move(command)})) {}

ProcessStream::~ProcessStream() {
  if (state_->child) state_->child->close_and_wait(kEndTimeout);
}

Result<void> ProcessStream::start() {
  auto& [command, child, backoff] = *state_;
  if (child && !child->is_running()) return close_with_fault({});
  if (child) return {};
  if (backoff.left() > Duration::zero()) return failure(FaultKind::disconnected, text(command), backoff.message());
  auto pipes = make_pipes(text(command));
  if (!pipes) return failure(pipes.error());
  const auto process = spawn(command, *pipes);
  if (process == 0) return close_with_fault(fmt::format("cannot be run: {}", std::strerror(errno)));
  child = std::make_unique<Child>(process, *pipes);
  return {};
}

tl::unexpected<Fault> ProcessStream::close_with_fault(std::string why) {
  if (state_->child) {
    if (state_->child->is_settled()) state_->backoff.note_success();
    const auto exit = state_->child->kill();
    if (why.empty()) why = exit;
  }
  state_->child.reset();
  state_->backoff.note_failure(why);
  return failure(FaultKind::disconnected, text(state_->command), std::move(why));
}

Result<std::size_t> ProcessStream::read(std::span<std::byte> buffer, Duration within) {
  if (auto started = start(); !started) return failure(std::move(started.error()));
  const Deadline deadline(within);
  auto& child = *state_->child;
  while (true) {
    child.read_errors();
    const auto size = ::recv(child.line(), buffer.data(), buffer.size(), 0);
    if (size > 0) return static_cast<std::size_t>(size);
    if (size == 0 || !would_block()) {
      child.close_and_wait(Duration(std::chrono::milliseconds(100)));  // the exit status follows shortly
      return close_with_fault({});
    }
    if (!child.wait(deadline))
      return failure(FaultKind::timeout, text(state_->command), fmt::format("no data in {:.3f} s", to_seconds(within)));
  }
}

Result<void> ProcessStream::write(std::span<const std::byte> bytes, Duration within) {
  if (auto started = start(); !started) return started;
  const Deadline deadline(within);
  while (!bytes.empty()) {
    const auto sent = ::send(state_->child->line(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
      continue;
    }
    if (sent < 0 && !would_block()) return close_with_fault({});
    if (deadline.has_passed() || !wait_until_ready(state_->child->line(), POLLOUT, deadline))
      return close_with_fault(
          fmt::format("the program did not read its input for {:.3f} s and was stopped", to_seconds(within)));
  }
  return {};
}

void ProcessStream::kill() {
  if (state_->child) (void)close_with_fault("the program gave no valid answer and was stopped");
}

}  // namespace gyrotherm::drivers
