// SPDX-License-Identifier: Apache-2.0
/// How other programs speak to the one that carries a run out.
#include "sequencer/control/control_socket.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

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

/// Listens in a thread of its own until it goes, and keeps what it heard.
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

TEST(ControlSocket, AnswersWithWhatWasDone) {
  const tests::TestFolder folder;
  auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket) << text(socket.error());
  Listening listening(*socket, {.done = true, .text = "paused"});
  const auto answer = tell(folder / "run.db", *request_of("pause", ""), 5s);
  listening.end();
  ASSERT_TRUE(answer) << text(answer.error());
  EXPECT_EQ(*answer, (ControlAnswer{.done = true, .text = "paused"}));
  ASSERT_EQ(listening.heard.size(), 1u);
  EXPECT_EQ(listening.heard[0].command, OperatorCommand::pause);
}

TEST(ControlSocket, TheKernelSaysWhoSpeaks) {
  const tests::TestFolder folder;
  auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "noted"});
  ASSERT_TRUE(tell(folder / "run.db", *request_of("note", "from somebody else (uid 0)"), 5s));
  listening.end();
  EXPECT_NE(listening.speaker.find("(uid " + std::to_string(::getuid()) + ")"), std::string::npos) << listening.speaker;
}

TEST(ControlSocket, WhomAMonitorAsksForIsNamedBesideWhoTheKernelSaysItIs) {
  const tests::TestFolder folder;
  auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "noted"});
  auto request = *request_of("note", "the door was open");
  request.for_user = "anna";
  ASSERT_TRUE(tell(folder / "run.db", request, 5s));
  listening.end();
  const auto through = fmt::format("anna (through {}, uid {})", user_name(::getuid()), ::getuid());
  EXPECT_EQ(listening.speaker, through);
  ASSERT_EQ(listening.heard.size(), 1u);
  EXPECT_EQ(listening.heard[0].note, "the door was open");
}

TEST(ControlSocket, NobodyThereIsAMistakeAndASilentOneATimeout) {
  const tests::TestFolder folder;
  const auto nobody = tell(folder / "run.db", *request_of("pause", ""), 1s);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().kind, FaultKind::usage);
  auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket);
  const auto silent = tell(folder / "run.db", *request_of("pause", ""), 50ms);
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().kind, FaultKind::timeout);
}

TEST(ControlSocket, OneThatADeadProgramLeftIsReplacedAndAnythingElseIsNot) {
  const tests::TestFolder folder;
  {
    auto dead = ControlSocket::open(folder / "run.db");
    ASSERT_TRUE(dead);
    std::filesystem::create_hard_link(control_socket_path(folder / "run.db"), folder / "kept");
  }
  EXPECT_FALSE(std::filesystem::exists(control_socket_path(folder / "run.db"))) << "an orderly end takes it away";
  std::filesystem::rename(folder / "kept", control_socket_path(folder / "run.db"));
  const auto left = tell(folder / "run.db", *request_of("stop", ""), 1s);
  ASSERT_FALSE(left);
  EXPECT_EQ(left.error().kind, FaultKind::usage);
  EXPECT_TRUE(ControlSocket::open(folder / "run.db"));
  std::ofstream(control_socket_path(folder / "other.db")) << "somebody's file";
  EXPECT_FALSE(ControlSocket::open(folder / "other.db"));
}

TEST(ControlSocket, IsForOwnerAndGroup) {
  const tests::TestFolder folder;
  const auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket);
  struct stat found {};
  ASSERT_EQ(::stat(control_socket_path(folder / "run.db").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777, 0660u);
}

TEST(ControlSocket, IsReachedInAFolderOfAnyDepth) {
  const tests::TestFolder folder;
  const auto deep = folder / (std::string(90, 'a') + "/" + std::string(90, 'b'));
  std::filesystem::create_directories(deep);
  auto socket = ControlSocket::open(deep + "/run.db");
  ASSERT_TRUE(socket) << text(socket.error());
  Listening listening(*socket, {.done = false, .text = "it has ended"});
  const auto answer = tell(deep + "/run.db", *request_of("stop", ""), 5s);
  ASSERT_TRUE(answer) << text(answer.error());
  EXPECT_FALSE(answer->done);
}

/// A raw speaker: what it says, and what it hears.
std::string say_raw(const std::string& record, const std::string& message) {
  const Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto path = control_socket_path(record);
  std::copy(path.begin(), path.end(), address.sun_path);
  if (::connect(socket.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return "no";
  ::send(socket.number(), message.data(), message.size(), MSG_NOSIGNAL);
  char heard[5000];
  if (!ready(socket.number(), POLLIN, Deadline(5s))) return "nothing";
  const auto size = ::recv(socket.number(), heard, sizeof heard, 0);
  return {heard, static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

TEST(ControlSocket, NoMessageButAWholeOneOfThisVersionIsHeard) {
  const tests::TestFolder folder;
  auto socket = ControlSocket::open(folder / "run.db");
  ASSERT_TRUE(socket);
  Listening listening(*socket, {.done = true, .text = "done"});
  for (const auto& message :
       {std::string("abort"), std::string("gyrotherm-tell/2 abort "), std::string("gyrotherm-tell/1 ABORT "),
        std::string("gyrotherm-tell/1 abort now"), std::string("gyrotherm-tell/1 for= abort "),
        std::string("gyrotherm-tell/1 for=a/b abort "), std::string("gyrotherm-tell/1 for=anna"),
        std::string("gyrotherm-tell/1 note \n"), std::string(4500, 'x'), std::string("\0\0\0", 3)})
    EXPECT_TRUE(say_raw(folder / "run.db", message).starts_with("gyrotherm-tell/1 refused ")) << message;
  listening.end();
  EXPECT_TRUE(listening.heard.empty());
}

TEST(ControlSocket, WhoConnectsAndSaysNothingKeepsNobodyOut) {
  const tests::TestFolder folder;
  auto socket = ControlSocket::open(folder / "run.db");
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
  EXPECT_TRUE(tell(folder / "run.db", *request_of("pause", ""), 5s));
}

}  // namespace
}  // namespace gyrotherm::control
