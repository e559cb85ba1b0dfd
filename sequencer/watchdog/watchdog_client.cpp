// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/watchdog_client.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <utility>

#include "core/deadline.hpp"
#include "core/process.hpp"
#include "sequencer/watchdog/guard.hpp"
#include "sequencer/watchdog/guard_post.hpp"

extern char** environ;

namespace gyrotherm::watchdog {
namespace {

using std::chrono::steady_clock;

constexpr const char* kGuardProgram = "gyrotherm-make-safe";
constexpr auto kCheckInterval = std::chrono::milliseconds(500);
constexpr auto kWatchTimeout = std::chrono::seconds(5);
constexpr auto kAnswerTimeout = std::chrono::seconds(5);

}  // namespace

/// The executable of the guard. The file stays open from the start of the run, so the guard can be restarted even after
/// an upgrade has removed or replaced the file.
class GuardProgram {
 public:
  GuardProgram() : path_(sibling_program_path(kGuardProgram)), file_(::open(path_.c_str(), O_PATH | O_CLOEXEC)) {}
  [[nodiscard]] const std::string& name() const { return path_; }
  /// Returns the path to run: the original path, or that of the open file if the original path is missing or belongs to
  /// another file now.
  [[nodiscard]] std::string path() const {
    struct stat held {
    }, named{};
    if (!file_.is_open() || ::fstat(file_.number(), &held) != 0) return path_;
    const bool is_there =
        ::stat(path_.c_str(), &named) == 0 && named.st_dev == held.st_dev && named.st_ino == held.st_ino;
    return is_there ? path_ : fmt::format("/proc/self/fd/{}", file_.number());
  }

 private:
  std::string path_;
  Descriptor file_;
};

namespace {

/// Starts the program with no signal blocked, in a new session, so signals from a terminal do not reach it. `input` is
/// its standard input. Returns an error number, 0 for none.
int spawn(const GuardProgram& program, const std::string& record, int input, pid_t& pid) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK);
  std::string name = program.name(), option = "--guard", path = record;
  const std::array<char*, 4> arguments{name.data(), option.data(), path.data(), nullptr};
  const int failed = ::posix_spawn(&pid, program.path().c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return failed;
}

/// Returns systemd's limit of silence, or nothing if systemd does not watch this program.
std::optional<std::string> watchdog_limit() {
  const char* limit = std::getenv("WATCHDOG_USEC");
  const char* pid = std::getenv("WATCHDOG_PID");
  if (!limit || (pid && std::to_string(::getpid()) != pid)) return {};
  return limit;
}

bool send_all(int line, std::string_view bytes) {
  while (!bytes.empty()) {
    const auto sent = ::send(line, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR) return false;
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

/// Returns true if the guard reports in time that it watches.
bool confirms_watching(int line) {
  char answer = 0;
  return wait_until_ready(line, POLLIN, Deadline(kWatchTimeout)) && ::recv(line, &answer, 1, MSG_DONTWAIT) == 1 &&
         answer == kWatching;
}

}  // namespace

std::optional<NotifySocket> NotifySocket::from_environment() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  return address && *address ? at(address) : std::nullopt;
}

std::optional<NotifySocket> NotifySocket::at(std::string address) {
  if (address.empty() || address.size() >= sizeof(sockaddr_un::sun_path)) return {};
  Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.is_open()) return {};
  return NotifySocket(std::move(socket), std::move(address));
}

void NotifySocket::notify(std::string_view state) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), to.sun_path);
  if (to.sun_path[0] == '@') to.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  ::sendto(socket_.number(), state.data(), state.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to), size);
}

/// The state that the client and its threads share.
struct WatchdogClient::SharedState {
  /// A failure and its description. The description remains available for some seconds after the failure ends, so a
  /// poll does not miss it.
  class Trouble {
   public:
    void begin(std::string words) {
      words_ = std::move(words);
      is_active_ = true;
      seen_ = steady_clock::now();
    }
    void end() {
      if (std::exchange(is_active_, false)) seen_ = steady_clock::now();
    }
    [[nodiscard]] std::string words() const {
      return is_active_ || steady_clock::now() - seen_ < kShownFor ? words_ : std::string();
    }

   private:
    static constexpr auto kShownFor = std::chrono::seconds(10);
    std::string words_;
    bool is_active_ = false;
    steady_clock::time_point seen_{};
  };

  SharedState(SafeState what, std::string where) : safe_state(std::move(what)), place(std::move(where)) {}

  const SafeState safe_state;
  const std::string place;  ///< name of the chamber's lock
  const GuardProgram program;
  std::mutex mutex;  ///< guards everything below
  std::condition_variable change;
  /// Line to the guard; closed: no guard.
  Descriptor line;
  pid_t guard = -1;  ///< its process
  /// The guard has reported that it watches.
  bool watching = false;
  /// Time of the first byte that the guard has not answered.
  std::optional<steady_clock::time_point> unanswered;
  /// Process of a guard that is starting and has not reported yet; -1: none.
  pid_t starting = -1;
  Trouble guard_trouble, file_trouble;
  bool stop = false;
  /// A tick was done, so this program drives the chamber.
  bool drives = false;
  int threads = 0;

  Result<void> start_guard();
  void note_start(pid_t pid);
  void send(char byte);
  void listen();
  void check_guard();
  void check_file();
  void run_every_interval(void (SharedState::*chore)());
};

/// Kills a guard before closing its line. A guard that was merely stopped could resume later and treat the closed line
/// as a failure.
void end_guard(pid_t pid, Descriptor line) {
  if (pid > 0) {
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
  }
  line.close();
}

/// Notes the guard that is starting, so that end_watch() can end it. If end_watch() came before, ends it here.
void WatchdogClient::SharedState::note_start(pid_t pid) {
  const std::lock_guard lock(mutex);
  starting = pid;
  if (stop && pid > 0) ::kill(pid, SIGKILL);
}

/// Starts a guard that replaces the previous one. The previous guard is ended as soon as the new guard is active. Call
/// it without the lock, because starting a program may take long.
Result<void> WatchdogClient::SharedState::start_guard() {
  const auto refuse = [&](const std::string& why) {
    return failure(FaultKind::bad_file, program.name(), "the guard cannot be started: " + why);
  };
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return refuse(std::strerror(errno));
  Descriptor own(ends[0]);
  Descriptor theirs(ends[1]);
  pid_t pid = -1;
  if (const int failed = spawn(program, safe_state.record, theirs.number(), pid); failed != 0)
    return refuse(std::strerror(failed));
  theirs.close();
  note_start(pid);
  const char preparing = kPreparing;
  if (!send_all(own.number(), safe_state_message(to_text(safe_state))) || !send_all(own.number(), {&preparing, 1}) ||
      !confirms_watching(own.number())) {
    note_start(-1);
    end_guard(pid, std::move(own));
    return refuse("it does not confirm that it is watching");
  }
  std::unique_lock lock(mutex);
  starting = -1;
  auto line_before = std::exchange(line, std::move(own));
  const auto guard_before = std::exchange(guard, pid);
  watching = true;
  unanswered.reset();
  if (stop) send(kGoodBye);  // requested during the start
  lock.unlock();
  end_guard(guard_before, std::move(line_before));
  return {};
}

/// Sends one byte. Call it with the lock.
void WatchdogClient::SharedState::send(char byte) {
  if (!line.is_open()) return;
  const auto sent = ::send(line.number(), &byte, 1, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent < 0 && errno == EPIPE) watching = false;
  if (!unanswered) unanswered = steady_clock::now();
}

/// Reads the guard's answers. Call it with the lock.
void WatchdogClient::SharedState::listen() {
  std::array<char, 64> heard;
  while (line.is_open()) {
    const auto size = ::recv(line.number(), heard.data(), heard.size(), MSG_DONTWAIT);
    if (size < 0 && would_block()) return;
    if (size <= 0) return void(watching = false);
    unanswered.reset();
  }
}

void WatchdogClient::SharedState::check_guard() {
  std::unique_lock lock(mutex);
  listen();
  const bool silent = unanswered && steady_clock::now() - *unanswered > kAnswerTimeout;
  if (watching && !silent) {
    guard_trouble.end();
    const bool relieves = drives && !place.empty();
    lock.unlock();
    if (relieves) relieve_guards(place, safe_state.record);
    return;
  }
  const auto why = watching ? "did not answer" : "had ended";
  lock.unlock();
  const auto started = start_guard();
  lock.lock();
  if (started)
    guard_trouble.begin(fmt::format("the guard {}, and was replaced", why));
  else
    guard_trouble.begin("there is no guard to make the chamber safe: " + text(started.error()));
}

/// Restores the safe-state file. If end_watch() came meanwhile, removes it again.
void WatchdogClient::SharedState::check_file() {
  const auto path = safe_state_path(safe_state.record);
  const auto found = read_safe_state(path);
  const bool in_place = found && *found && **found == safe_state;
  const auto written = in_place ? Result<void>() : write_safe_state(safe_state);
  const std::lock_guard lock(mutex);
  if (in_place) return file_trouble.end();
  if (stop) return remove_safe_state(safe_state.record);
  file_trouble.begin(written ? path + " was missing or changed; it was restored" : text(written.error()));
}

/// Calls `chore` at every interval until the threads are stopped. Main function of both threads.
void WatchdogClient::SharedState::run_every_interval(void (SharedState::*chore)()) {
  block_signals();
  std::unique_lock lock(mutex);
  while (!change.wait_for(lock, kCheckInterval, [this] { return stop; })) {
    lock.unlock();
    (this->*chore)();
    lock.lock();
  }
  --threads;
  change.notify_all();
}

Result<std::unique_ptr<WatchdogClient>> WatchdogClient::start(const SafeState& safe_state, const std::string& place) {
  auto shared = std::make_shared<SharedState>(safe_state, place);
  const auto before = read_safe_state(safe_state_path(safe_state.record));
  if (auto written = write_safe_state(safe_state); !written) return failure(written.error());
  remove_give_up(safe_state.record);
  for (const int number : {SIGTSTP, SIGTTOU, SIGTTIN}) std::signal(number, SIG_IGN);  // no accidental stop of a run
  const bool was_abandoned = before && *before;
  if (auto started = shared->start_guard(); !started) {
    if (!was_abandoned || !write_safe_state(**before)) remove_safe_state(safe_state.record);
    return failure(started.error());
  }
  std::unique_ptr<WatchdogClient> line(new WatchdogClient(shared));
  line->took_over_ = was_abandoned;
  line->systemd_ = NotifySocket::from_environment();
  line->watchdog_limit_ = line->systemd_ ? watchdog_limit() : std::nullopt;
  if (line->systemd_) line->systemd_->notify("READY=1");
  if (line->watchdog_limit_)  // uploading a program takes long
    line->systemd_->notify(fmt::format("WATCHDOG_USEC={}", WatchLimits().preparing / std::chrono::microseconds(1)));
  shared->threads = 2;
  line->guard_thread_ = std::thread([shared] { shared->run_every_interval(&SharedState::check_guard); });
  line->file_thread_ = std::thread([shared] { shared->run_every_interval(&SharedState::check_file); });
  return line;
}

void WatchdogClient::heartbeat() {
  if (watchdog_limit_ && !beating_) systemd_->notify("WATCHDOG_USEC=" + *watchdog_limit_);
  beating_ = true;
  if (watchdog_limit_) systemd_->notify("WATCHDOG=1");
  const std::lock_guard lock(shared_->mutex);
  shared_->drives = true;
  shared_->send(kAlive);
}

std::map<std::string, std::string> WatchdogClient::troubles() const {
  const std::lock_guard lock(shared_->mutex);
  std::map<std::string, std::string> troubles{{"guard", shared_->guard_trouble.words()},
                                              {"safe-state file", shared_->file_trouble.words()}};
  std::erase_if(troubles, [](const auto& trouble) { return trouble.second.empty(); });
  return troubles;
}

/// Ends the threads. Detaches them if one hangs in the disk.
void WatchdogClient::end_threads() {
  if (!guard_thread_.joinable()) return;
  std::unique_lock lock(shared_->mutex);
  shared_->stop = true;
  shared_->change.notify_all();
  const bool ended = shared_->change.wait_for(lock, std::chrono::seconds(1), [this] { return shared_->threads == 0; });
  lock.unlock();
  for (auto* thread : {&guard_thread_, &file_thread_}) ended ? thread->join() : thread->detach();
}

/// Sends kGoodBye before any step that may take long. While a disk hangs, the safe-state file cannot be removed.
void WatchdogClient::end_watch() {
  {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->drives && !shared_->place.empty()) relieve_guards(shared_->place, shared_->safe_state.record);
    shared_->send(kGoodBye);
    shared_->stop = true;
    // A guard that starts now would see the line close without a good-bye.
    if (shared_->starting > 0) ::kill(shared_->starting, SIGKILL);
  }
  if (systemd_) systemd_->notify("STOPPING=1");
  end_threads();
  remove_safe_state(shared_->safe_state.record);
}

/// Leaves the line to the guard open until the process ends, so that the process can report the result of the run. When
/// the line closes, the guard kills the process if it is still alive.
WatchdogClient::~WatchdogClient() {
  end_threads();
  const std::lock_guard lock(shared_->mutex);
  (void)std::move(shared_->line).release();
}

}  // namespace gyrotherm::watchdog
