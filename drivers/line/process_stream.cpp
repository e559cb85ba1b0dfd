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

constexpr Duration kEndsWithin = std::chrono::milliseconds(500), kDiesWithin = std::chrono::seconds(1);
/// A program that ran for this long has started successfully.
constexpr Duration kSettledAfter = std::chrono::seconds(10);
constexpr std::size_t kLastWords = 200;  ///< bytes

std::string describe_exit(int status) {
  if (WIFSIGNALED(status)) return fmt::format("the program was ended by signal {}", WTERMSIG(status));
  return fmt::format("the program ended with exit code {}", WEXITSTATUS(status));
}

/// Both ends of the connection for data, and both ends of the pipe for stderr.
struct Pipes {
  Descriptor ours, theirs, complaints, complains;
};

Result<Pipes> make_pipes(const std::string& place) {
  std::array<int, 2> both{}, errors{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, both.data()) != 0)
    return failure(FaultKind::disconnected, place, std::strerror(errno));
  Pipes pipes{.ours = Descriptor(both[0]), .theirs = Descriptor(both[1]), .complaints = {}, .complains = {}};
  if (::pipe2(errors.data(), O_CLOEXEC) != 0) return failure(FaultKind::disconnected, place, std::strerror(errno));
  pipes.complaints = Descriptor(errors[0]);
  pipes.complains = Descriptor(errors[1]);
  for (const int end : {pipes.ours.number(), pipes.complaints.number()}) ::fcntl(end, F_SETFL, O_NONBLOCK);
  return pipes;
}

/// Starts the program. Returns its process, or 0 with errno set.
pid_t spawn(const ProgramCommand& command, const Pipes& pipes) {
  std::vector<char*> words;
  for (const auto& word : command.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addchdir_np(&files, command.folder.c_str());
  posix_spawn_file_actions_adddup2(&files, pipes.theirs.number(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, pipes.theirs.number(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, pipes.complains.number(), STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  posix_spawnattr_t how;
  posix_spawnattr_init(&how);
  sigset_t none, pipes_end;
  sigemptyset(&none);
  sigemptyset(&pipes_end);
  sigaddset(&pipes_end, SIGPIPE);
  posix_spawnattr_setsigmask(&how, &none);
  posix_spawnattr_setsigdefault(&how, &pipes_end);
  posix_spawnattr_setpgroup(&how, 0);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, words.front(), &files, &how, words.data(), environ);
  posix_spawnattr_destroy(&how);
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
  if (file.empty()) return failure(FaultKind::disconnected, word, "program not found in the path");
  return file;
}

/// A running process, with this side's ends of its pipes.
class ProcessStream::Child {
 public:
  Child(pid_t process, Pipes& pipes)
      : process_(process),
        watched_(static_cast<int>(::syscall(SYS_pidfd_open, process, 0))),
        line_(std::move(pipes.ours)),
        complaints_(std::move(pipes.complaints)) {}
  ~Child() { (void)end(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  [[nodiscard]] int line() const { return line_.number(); }
  [[nodiscard]] bool is_settled() const { return settling_.over(); }
  [[nodiscard]] bool runs() const {
    return !watched_.is_open() || !ready(watched_.number(), POLLIN, Deadline(Duration::zero()));
  }
  void let_end(Duration within) {
    ::shutdown(line_.number(), SHUT_RDWR);
    if (watched_.is_open()) (void)ready(watched_.number(), POLLIN, Deadline(within));
  }
  /// Kills the process group. Returns how the process ended and its last line on stderr. The process number cannot be
  /// reused before waitpid(), so no other process is killed.
  std::string end() {
    if (process_ == 0) return {};
    ::kill(-process_, SIGKILL);
    ::kill(process_, SIGKILL);
    if (watched_.is_open()) (void)ready(watched_.number(), POLLIN, Deadline(kDiesWithin));
    int status = 0;
    const bool dead = ::waitpid(process_, &status, WNOHANG) == process_;
    process_ = 0;
    listen();
    const auto said = last_line();
    return (dead ? describe_exit(status) : "the program was killed but has not ended yet") +
           (said.empty() ? said : fmt::format("; its last output was \"{}\"", said));
  }
  /// Waits for output of the program and returns true, or returns false at the deadline. Reads the program's stderr
  /// while waiting.
  [[nodiscard]] bool wait(const Deadline& deadline) {
    while (!deadline.over()) {
      std::array<pollfd, 2> lines{{{line(), POLLIN, 0}, {complaints_.number(), POLLIN, 0}}};
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline.left());
      const int found = ::poll(lines.data(), lines.size(), static_cast<int>(left.count()));
      if (lines[1].revents != 0) listen();
      if (lines[0].revents != 0) return true;
      if (found < 0 && errno != EINTR) return false;
    }
    return false;
  }
  /// Reads the available stderr output of the program, up to a limit. Otherwise the program would block on a full pipe.
  void listen() {
    constexpr int kMostPieces = 64;
    std::array<char, 4096> some{};
    for (int i = 0; i < kMostPieces && complaints_.is_open(); ++i) {
      const auto size = ::read(complaints_.number(), some.data(), some.size());
      if (size == 0) complaints_.close();
      if (size <= 0) return;
      said_.append(some.data(), static_cast<std::size_t>(size));
      if (said_.size() > some.size()) said_.erase(0, said_.size() - some.size());
    }
  }

 private:
  [[nodiscard]] std::string last_line() const {
    auto whole = trimmed(said_, " \t\r\n");
    if (const auto end = whole.rfind('\n'); end != std::string_view::npos) whole.remove_prefix(end + 1);
    return plain(whole.substr(0, kLastWords));
  }

  pid_t process_;
  Descriptor watched_, line_, complaints_;
  Deadline settling_{kSettledAfter};
  std::string said_;
};

struct ProcessStream::Inside {
  ProgramCommand command;
  std::unique_ptr<Child> child{};
  Backoff backoff{};
  /// Reason for the latest end.
  std::string why{};
};

ProcessStream::ProcessStream(ProgramCommand command)
    : inside_(std::make_unique<Inside>(Inside{.command = std::move(command)})) {}

ProcessStream::~ProcessStream() {
  if (inside_->child) inside_->child->let_end(kEndsWithin);
}

Result<void> ProcessStream::start() {
  auto& [command, child, backoff, why] = *inside_;
  if (child && !child->runs()) return broken({});
  if (child) return {};
  if (backoff.left() > Duration::zero())
    return failure(FaultKind::disconnected, text(command),
                   fmt::format("{}; next try in {:.1f} s", why, to_seconds(backoff.left())));
  auto pipes = make_pipes(text(command));
  if (!pipes) return failure(pipes.error());
  const auto process = spawn(command, *pipes);
  if (process == 0) return broken(fmt::format("cannot be run: {}", std::strerror(errno)));
  child = std::make_unique<Child>(process, *pipes);
  return {};
}

tl::unexpected<Fault> ProcessStream::broken(std::string why) {
  if (inside_->child) {
    if (inside_->child->is_settled()) inside_->backoff.succeeded();
    const auto how = inside_->child->end();
    if (why.empty()) why = how;
  }
  inside_->child.reset();
  inside_->backoff.failed();
  inside_->why = why;
  return failure(FaultKind::disconnected, text(inside_->command), std::move(why));
}

Result<std::size_t> ProcessStream::read(std::span<std::byte> buffer, Duration within) {
  if (auto started = start(); !started) return failure(std::move(started.error()));
  const Deadline deadline(within);
  auto& child = *inside_->child;
  while (true) {
    child.listen();
    const auto size = ::recv(child.line(), buffer.data(), buffer.size(), 0);
    if (size > 0) return static_cast<std::size_t>(size);
    if (size == 0 || !would_block()) {
      child.let_end(Duration(std::chrono::milliseconds(100)));  // the exit status follows shortly
      return broken({});
    }
    if (!child.wait(deadline))
      return failure(FaultKind::timeout, text(inside_->command),
                     fmt::format("no data in {:.3f} s", to_seconds(within)));
  }
}

Result<void> ProcessStream::write(std::span<const std::byte> bytes, Duration within) {
  if (auto started = start(); !started) return started;
  const Deadline deadline(within);
  while (!bytes.empty()) {
    const auto sent = ::send(inside_->child->line(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
      continue;
    }
    if (sent < 0 && !would_block()) return broken({});
    if (deadline.over() || !ready(inside_->child->line(), POLLOUT, deadline))
      return broken(fmt::format("the program read nothing in {:.3f} s and was stopped", to_seconds(within)));
  }
  return {};
}

void ProcessStream::kill() {
  if (inside_->child) (void)broken("the program gave no valid answer and was stopped");
}

}  // namespace gyrotherm::drivers
