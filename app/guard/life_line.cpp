#include "app/guard/life_line.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "app/guard/guard.hpp"

extern char** environ;

namespace gyrotherm {
namespace {

constexpr const char* kGuard = "gyrotherm-make-safe";

std::string guard_program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).replace_filename(kGuard).string();
}

/// In a session of its own, so that a terminal's signals do not reach it; `input` is its standard input.
int spawn(const std::string& program, const std::string& record, int input) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string name = program, option = "--guard", path = record;
  const std::array<char*, 4> arguments{name.data(), option.data(), path.data(), nullptr};
  pid_t pid = 0;
  const int failed = ::posix_spawn(&pid, program.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return failed;
}

/// How long systemd lets this program be silent; nothing if it does not watch this very program.
std::optional<std::string> watchdog_limit() {
  const char* limit = std::getenv("WATCHDOG_USEC");
  const char* whose = std::getenv("WATCHDOG_PID");
  if (!limit || (whose && std::to_string(::getpid()) != whose)) return {};
  return limit;
}

}  // namespace

Result<std::unique_ptr<LifeLine>> LifeLine::tie(const Armed& armed) {
  std::unique_ptr<LifeLine> line(new LifeLine(armed));
  if (auto written = arm(armed); !written) return failure(written.error());
  std::signal(SIGTSTP, SIG_IGN);
  line->systemd_ = NotifySocket::from_environment();
  line->limit_ = line->systemd_ ? watchdog_limit() : std::nullopt;
  if (line->systemd_) line->systemd_->tell("READY=1");
  if (line->limit_)  // an upload may take long
    line->systemd_->tell(fmt::format("WATCHDOG_USEC={}", WatchLimits().preparing / std::chrono::microseconds(1)));
  else if (auto started = line->start_guard(); !started) {
    disarm(armed.record);
    return failure(started.error());
  }
  return line;
}

Result<void> LifeLine::start_guard() {
  const auto refuse = [](const std::string& where, int error) {
    return failure(FaultKind::bad_file, where, fmt::format("the guard cannot be started: {}", std::strerror(error)));
  };
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return refuse(kGuard, errno);
  const Descriptor theirs(ends[0]);
  pipe_ = ends[1];
  ::fcntl(pipe_, F_SETFL, O_NONBLOCK);
  const auto program = guard_program();
  if (const int failed = spawn(program, armed_.record, theirs.number()); failed != 0) {
    hang_up();
    return refuse(program, failed);
  }
  send(kPreparing);
  return {};
}

void LifeLine::hang_up() {
  if (pipe_ != kNoDescriptor) ::close(pipe_);
  pipe_ = kNoDescriptor;
}

void LifeLine::send(char byte) {
  if (pipe_ != kNoDescriptor && ::write(pipe_, &byte, 1) < 0 && errno == EPIPE) hang_up();
}

void LifeLine::beat() {
  if (limit_ && !beating_) systemd_->tell("WATCHDOG_USEC=" + *limit_);
  beating_ = true;
  if (limit_) return systemd_->tell("WATCHDOG=1");
  send(kAlive);
  if (pipe_ == kNoDescriptor && start_guard()) send(kAlive);
}

void LifeLine::good_bye() {
  disarm(armed_.record);
  if (systemd_) systemd_->tell("STOPPING=1");
  send(kGoodBye);
  hang_up();
}

}  // namespace gyrotherm
