// SPDX-License-Identifier: Apache-2.0
/// The socket through which other programs send requests to a run.
#include "sequencer/control/control_socket.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/deadline.hpp"
#include "core/process.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::control {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

/// Writes the status file of the program that carries out `record`.
void write_status(const std::string& record, std::int64_t pid = ::getpid()) {
  std::ofstream(record + ".status") << fmt::format(R"({{"schema":"gyrotherm-status/1","pid":{}}})", pid);
}

/// Opens a socket next to the record, and writes the status file of its program.
Result<ControlSocket> open_with_status(const std::string& record) {
  write_status(record);
  return ControlSocket::open(record);
}

/// Listens in a thread until its end, and keeps the requests.
class Listening {
 public:
  explicit Listening(ControlSocket& socket, ControlAnswer answer)
      : thread_([this, &socket, answer = std::move(answer)](std::stop_token stop) {
          while (!stop.stop_requested()) {
            socket.listen([&](const ControlRequest& request, const std::string& who) {
              heard.push_back(request);
              speaker = who;
              return answer;
            });
            std::this_thread::sleep_for(2ms);
          }
        }) {}
  void end() { thread_ = {}; }
  std::vector<ControlRequest> heard;
  std::string speaker;

 private:
  std::jthread thread_;
};

TEST(ControlSocket, AnswersWithResult) {
  const tests::TestFolder folder;
  auto socket = open_with_status(folder / "run.db");
  ASSERT_TRUE(socket) << text(socket.error());
  Listening listening(*socket, {.done = true, .text = "paused"});
  const auto answer = send_request(folder / "run.db", *make_request("pause", ""), 5s);
  listening.end();
  ASSERT_TRUE(answer) << text(answer.error());
  EXPECT_EQ(*answer, (ControlAnswer{.done = true, .text = "paused"}));
  ASSERT_EQ(listening.heard.size(), 1u);
  EXPECT_EQ(listening.heard[0].command, OperatorCommand::pause);
}

TEST(ControlSocket, IdentifiesClientByKernelCredentials) {
  const tests::TestFolder folder;
  auto socket = open_with_status(folder / "run.db");
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "noted"});
  ASSERT_TRUE(send_request(folder / "run.db", *make_request("note", "from somebody else (uid 0)"), 5s));
  listening.end();
  EXPECT_NE(listening.speaker.find("(uid " + std::to_string(::getuid()) + ")"), std::string::npos) << listening.speaker;
}

TEST(ControlSocket, RecordsUserOfMonitorNextToKernelUser) {
  const tests::TestFolder folder;
  auto socket = open_with_status(folder / "run.db");
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "noted"});
  auto request = *make_request("note", "the door was open");
  request.for_user = "anna";
  ASSERT_TRUE(send_request(folder / "run.db", request, 5s));
  listening.end();
  const auto through = fmt::format("anna (through {}, uid {})", user_name(::getuid()), ::getuid());
  EXPECT_EQ(listening.speaker, through);
  ASSERT_EQ(listening.heard.size(), 1u);
  EXPECT_EQ(listening.heard[0].note, "the door was open");
}

TEST(ControlSocket, ReportsMissingListenerAndTimeOutOfSilentOne) {
  const tests::TestFolder folder;
  const auto pause = *make_request("pause", "");
  const auto nothing = send_request(folder / "run.db", pause, 1s);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().kind, FaultKind::bad_file);
  std::ofstream(folder / "run.db") << "the record";
  const auto nobody = send_request(folder / "run.db", pause, 1s);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().kind, FaultKind::usage);
  auto socket = open_with_status(folder / "run.db");
  ASSERT_TRUE(socket);
  const auto silent = send_request(folder / "run.db", pause, 50ms);
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().kind, FaultKind::timeout);
}

TEST(ControlSocket, ReplacesSocketOfDeadProgramOnly) {
  const tests::TestFolder folder;
  {
    auto dead = ControlSocket::open(folder / "run.db");
    ASSERT_TRUE(dead);
    std::filesystem::create_hard_link(control_socket_path(folder / "run.db"), folder / "kept");
  }
  EXPECT_FALSE(std::filesystem::exists(control_socket_path(folder / "run.db"))) << "an orderly end removes it";
  std::filesystem::rename(folder / "kept", control_socket_path(folder / "run.db"));
  std::ofstream(folder / "run.db") << "the record";
  const auto left = send_request(folder / "run.db", *make_request("stop", ""), 1s);
  ASSERT_FALSE(left);
  EXPECT_EQ(left.error().kind, FaultKind::usage);
  EXPECT_TRUE(ControlSocket::open(folder / "run.db"));
  std::ofstream(control_socket_path(folder / "other.db")) << "a file of another program";
  EXPECT_FALSE(ControlSocket::open(folder / "other.db"));
}

TEST(ControlSocket, IsAccessibleToOwnerAndGroupOnly) {
  const tests::TestFolder folder;
  const auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket);
  struct stat found {};
  ASSERT_EQ(::stat(control_socket_path(folder / "run.db").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777, 0660u);
}

TEST(ControlSocket, IsAccessibleToOwnerOnlyWhenUmaskExcludesGroup) {
  for (const auto& [mask, mode] : {std::pair{0000u, 0660u}, {0022u, 0660u}, {0027u, 0660u}, {0077u, 0600u}}) {
    const tests::TestFolder folder;
    const auto before = ::umask(mask);
    const auto socket = ControlSocket::open(folder / "run.db");
    ::umask(before);
    ASSERT_TRUE(socket);
    struct stat found {};
    ASSERT_EQ(::stat(control_socket_path(folder / "run.db").c_str(), &found), 0);
    EXPECT_EQ(found.st_mode & 0777, mode) << mask;
  }
}

/// Another process that has replaced the run's socket and answers every request with "done".
class ImpostorListener {
 public:
  explicit ImpostorListener(const std::string& record, uid_t uid = ::geteuid()) {
    int ready[2];
    EXPECT_EQ(::pipe(ready), 0);
    pid_ = ::fork();
    if (pid_ == 0) {
      const bool is_other = uid == ::geteuid() || ::setuid(uid) == 0;
      auto socket = ControlSocket::open(record);
      [[maybe_unused]] const auto told = ::write(ready[1], is_other && socket ? "y" : "n", 1);
      for (;; ::poll(nullptr, 0, 2)) {
        if (!socket) continue;
        socket->listen([](const ControlRequest&, const std::string&) {
          return ControlAnswer{.done = true, .text = "aborts: the chamber is made safe"};
        });
      }
    }
    char answer = 0;
    EXPECT_EQ(::read(ready[0], &answer, 1), 1);
    EXPECT_EQ(answer, 'y');
    ::close(ready[0]), ::close(ready[1]);
  }
  ~ImpostorListener() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ImpostorListener(const ImpostorListener&) = delete;
  ImpostorListener& operator=(const ImpostorListener&) = delete;
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
};

void expect_refused(const std::string& record, const char* word) {
  const auto text = std::string(word) == "note" ? "looked" : "";
  const auto answer = send_request(record, *make_request(word, text), 5s);
  ASSERT_FALSE(answer) << word << ": " << answer->text;
  EXPECT_EQ(answer.error().kind, FaultKind::refused) << text << answer.error().what;
}

TEST(ControlSocket, RefusesListenerThatStatusFileDoesNotName) {
  const tests::TestFolder folder;
  const auto record = folder / "run.db";
  const auto own = open_with_status(record);
  ASSERT_TRUE(own);
  std::filesystem::rename(control_socket_path(record), folder / "away");
  const ImpostorListener impostor(record);
  for (const auto* word : {"abort", "stop", "pause", "note"}) expect_refused(record, word);
  const auto answer = send_request(record, *make_request("abort", ""), 5s);
  EXPECT_NE(answer.error().what.find(fmt::format("process {} of", impostor.pid())), std::string::npos)
      << answer.error().what;
}

TEST(ControlSocket, RefusesListenerWhenStatusFileIsUnusable) {
  const tests::TestFolder folder;
  const auto record = folder / "run.db", status = record + ".status";
  auto socket = ControlSocket::open(record);
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "done"});
  expect_refused(record, "abort");  // no status file
  for (const auto* text : {"", "{}", R"({"pid":"1"})", R"({"pid":0})", "[", "gone"}) {
    std::ofstream(status) << text;
    expect_refused(record, "abort");
  }
  std::filesystem::remove(status);
  write_status(folder / "other.db");
  std::filesystem::create_symlink(folder / "other.db.status", status);
  expect_refused(record, "abort");
  listening.end();
  EXPECT_TRUE(listening.heard.empty());
}

TEST(ControlSocket, RefusesListenerOfAnotherUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  constexpr uid_t kStranger = 65534;
  const tests::TestFolder folder;
  const auto record = folder / "run.db";
  std::filesystem::permissions(folder / "", std::filesystem::perms::all);
  std::ofstream(record) << "record";
  const ImpostorListener impostor(record, kStranger);
  write_status(record, impostor.pid());
  expect_refused(record, "abort");  // the status file belongs to root
  ASSERT_EQ(::chown((record + ".status").c_str(), kStranger, kStranger), 0);
  expect_refused(record, "abort");  // the record belongs to root
  ASSERT_EQ(::chown(record.c_str(), kStranger, kStranger), 0);
  const auto answer = send_request(record, *make_request("abort", ""), 5s);
  EXPECT_TRUE(answer) << "the run of that user";
}

TEST(ControlSocket, WorksInFolderOfAnyDepth) {
  const tests::TestFolder folder;
  const auto deep = folder / (std::string(90, 'a') + "/" + std::string(90, 'b'));
  std::filesystem::create_directories(deep);
  auto socket = open_with_status(deep + "/run.db");
  ASSERT_TRUE(socket) << text(socket.error());
  Listening listening(*socket, {.done = false, .text = "it has ended"});
  const auto answer = send_request(deep + "/run.db", *make_request("stop", ""), 5s);
  ASSERT_TRUE(answer) << text(answer.error());
  EXPECT_FALSE(answer->done);
}

/// Sends a raw message and returns the answer.
std::string send_raw(const std::string& record, const std::string& message) {
  const Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto path = control_socket_path(record);
  std::copy(path.begin(), path.end(), address.sun_path);
  if (::connect(socket.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return "no";
  ::send(socket.number(), message.data(), message.size(), MSG_NOSIGNAL);
  char heard[5000];
  if (!wait_until_ready(socket.number(), POLLIN, Deadline(5s))) return "nothing";
  const auto size = ::recv(socket.number(), heard, sizeof heard, 0);
  return {heard, static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

TEST(ControlSocket, RefusesIncompleteMessagesAndOtherVersions) {
  const tests::TestFolder folder;
  auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "done"});
  for (const auto& message :
       {std::string("abort"), std::string("gyrotherm-tell/2 abort "), std::string("gyrotherm-tell/1 ABORT "),
        std::string("gyrotherm-tell/1 pause now"), std::string("gyrotherm-tell/1 for= abort "),
        std::string("gyrotherm-tell/1 for=a/b abort "), std::string("gyrotherm-tell/1 for=anna"),
        std::string("gyrotherm-tell/1 note \n"), std::string(4500, 'x'), std::string("\0\0\0", 3)})
    EXPECT_TRUE(send_raw(folder / "run.db", message).starts_with("gyrotherm-tell/1 refused ")) << message;
  listening.end();
  EXPECT_TRUE(listening.heard.empty());
}

TEST(ControlSocket, AnswersWhenDescriptorsAreExhausted) {
  const tests::TestFolder folder;
  auto socket = open_with_status(folder / "run.db");
  ASSERT_TRUE(socket);
  const auto done = [](const ControlRequest&, const std::string&) {
    return ControlAnswer{.done = true, .text = "done"};
  };
  socket->listen(done);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  std::vector<pid_t> speakers;
  for (const auto* word : {"abort", "pause", "stop", "resume"}) {
    speakers.push_back(::fork());
    if (speakers.back() == 0) ::_exit(send_request(folder / "run.db", *make_request(word, ""), 5s) ? 0 : 1);
  }
  const auto few = rlimit{.rlim_cur = 64, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  std::vector<Descriptor> all;
  do all.emplace_back(::open("/dev/null", O_RDONLY));
  while (all.back().is_open());
  std::size_t answered = 0;
  for (const Deadline limit(10s); answered < speakers.size() && !limit.has_passed(); std::this_thread::sleep_for(2ms)) {
    socket->listen(done);
    int ended = 0;
    if (::waitpid(-1, &ended, WNOHANG) > 0 && ended == 0) ++answered;
  }
  all.clear();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(answered, speakers.size());
}

/// Hangs up on each client: before its message, with the message unread, or after reading it. Counts the messages read.
class HangingUpListener {
 public:
  enum class When { before_it_speaks, unread, read };
  HangingUpListener(const std::string& record, std::vector<When> times) : address_(socket_address(record)) {
    write_status(record);
    EXPECT_EQ(::bind(socket_.number(), reinterpret_cast<const sockaddr*>(&address_), sizeof address_), 0);
    EXPECT_EQ(::listen(socket_.number(), 8), 0);
    thread_ = std::jthread([this, times = std::move(times)] {
      for (const auto when : times) hang_up(when);
      socket_.close();
    });
  }
  int read() {
    thread_.join();
    return read_;
  }

 private:
  static sockaddr_un socket_address(const std::string& record) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const auto path = control_socket_path(record);
    std::copy(path.begin(), path.end(), address.sun_path);
    return address;
  }
  void hang_up(When when) {
    if (!wait_until_ready(socket_.number(), POLLIN, Deadline(5s))) return;
    const Descriptor speaker(::accept(socket_.number(), nullptr, nullptr));
    if (when == When::before_it_speaks) return;
    (void)wait_until_ready(speaker.number(), POLLIN, Deadline(5s));
    char message[5000];
    if (when == When::read && ::recv(speaker.number(), message, sizeof message, 0) > 0) ++read_;
  }

  Descriptor socket_{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)};
  sockaddr_un address_;
  int read_ = 0;
  std::jthread thread_;
};

TEST(ControlSocket, RetriesUntilMessageIsReadAndSendsItOnce) {
  using When = HangingUpListener::When;
  const tests::TestFolder folder;
  HangingUpListener listener(folder / "run.db", {When::unread, When::before_it_speaks, When::unread, When::read});
  const auto answer = send_request(folder / "run.db", *make_request("abort", ""), 5s);
  EXPECT_EQ(listener.read(), 1);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().kind, FaultKind::disconnected) << text(answer.error());
}

TEST(ControlSocket, ServesOthersWhileClientIsSilent) {
  const tests::TestFolder folder;
  auto socket = open_with_status(folder / "run.db");
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "done"});
  std::vector<Descriptor> silent;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto path = control_socket_path(folder / "run.db");
  std::copy(path.begin(), path.end(), address.sun_path);
  for (int i = 0; i < 50; ++i) {
    silent.emplace_back(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    ASSERT_EQ(::connect(silent.back().number(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  EXPECT_TRUE(send_request(folder / "run.db", *make_request("pause", ""), 5s));
}

}  // namespace
}  // namespace gyrotherm::control
