// SPDX-License-Identifier: Apache-2.0
/// The guard's watch over a pipe, and the identity of processes.
#include "sequencer/watchdog/guard.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <thread>

#include "sequencer/watchdog/child_work.hpp"
#include "sequencer/watchdog/watchdog_client.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/slept.hpp"

namespace gyrotherm::watchdog {
namespace {

struct Pipe {
  Pipe() { EXPECT_EQ(::pipe(ends), 0); }
  ~Pipe() { ::close(ends[0]), close(); }
  void send(const char* bytes) const { EXPECT_GT(::write(ends[1], bytes, std::string_view(bytes).size()), 0); }
  void close() {
    if (ends[1] >= 0) ::close(ends[1]);
    ends[1] = -1;
  }
  int ends[2]{};
};

TEST(Guard, EndsWatchAfterGoodBye) {
  Pipe pipe;
  pipe.send("p...q");
  EXPECT_EQ(watch(pipe.ends[0]), WatchEnd::good_bye);
}

TEST(Guard, TreatsEndWithoutGoodByeAsDeath) {
  Pipe pipe;
  pipe.send("p..");
  pipe.close();
  EXPECT_EQ(watch(pipe.ends[0]), WatchEnd::closed);
}

TEST(Guard, TreatsSilenceAsHangAndAllowsLongerPreparation) {
  Pipe pipe;
  pipe.send(".");
  EXPECT_EQ(watch(pipe.ends[0], {.silence = std::chrono::seconds(1), .preparing = std::chrono::hours(1)}),
            WatchEnd::silent);
  pipe.send("p");
  EXPECT_EQ(watch(pipe.ends[0], {.silence = std::chrono::hours(1), .preparing = std::chrono::seconds(1)}),
            WatchEnd::silent);
}

TEST(Guard, AnswersEachSignOfLife) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  ASSERT_EQ(::write(ends[1], ".", 1), 1);
  EXPECT_EQ(watch(ends[0], {.silence = std::chrono::seconds(1), .preparing = std::chrono::seconds(1)}),
            WatchEnd::silent);
  char heard = 0;
  EXPECT_EQ(::recv(ends[1], &heard, 1, MSG_DONTWAIT), 1);
  EXPECT_EQ(heard, kHeard);
  ::close(ends[0]), ::close(ends[1]);
}

TEST(Guard, ReadsOrdersFromFirstLineOnly) {
  Pipe pipe;
  pipe.send((safe_state_message("some text") + ".q").c_str());
  const auto orders = receive_safe_state(pipe.ends[0], std::chrono::seconds(5));
  ASSERT_TRUE(orders) << text(orders.error());
  EXPECT_EQ(*orders, "some text");
  EXPECT_EQ(watch(pipe.ends[0]), WatchEnd::good_bye);
}

TEST(Guard, RefusesInvalidOrders) {
  for (const auto* orders : {"p", "A\n", "Ax\n", "A123456789\nx", "A-1\nx", "A5\nabc", ""}) {
    Pipe pipe;
    if (*orders != '\0') pipe.send(orders);
    pipe.close();
    EXPECT_FALSE(receive_safe_state(pipe.ends[0], std::chrono::seconds(5)).has_value()) << orders;
  }
  Pipe silent;
  EXPECT_EQ(receive_safe_state(silent.ends[0], std::chrono::milliseconds(10)).error().kind, FaultKind::timeout);
}

TEST(ChildWork, ReportsLinesAndEnd) {
  ChildWork work([](const auto& send_line) { send_line("first"), send_line("second"); });
  EXPECT_EQ(work.next(std::chrono::seconds(60)), "first");
  EXPECT_EQ(work.next(std::chrono::seconds(60)), "second");
  EXPECT_FALSE(work.next(std::chrono::seconds(60)));
  EXPECT_TRUE(work.has_ended());
}

TEST(ChildWork, DoesNotDelayOthersWhenItHangs) {
  const tests::SleepMeter meter;
  {
    ChildWork work([](const auto& send_line) {
      send_line("begun");
      for (;;) ::pause();
    });
    EXPECT_EQ(work.next(std::chrono::seconds(60)), "begun");
    EXPECT_FALSE(work.next(std::chrono::milliseconds(50)));
    EXPECT_FALSE(work.has_ended());
  }
  EXPECT_LT(meter.slept(), std::chrono::seconds(5));
}

/// Starts a child that waits to be killed.
pid_t idle_child() {
  const auto child = ::fork();
  if (child == 0) {
    ::pause();
    ::_exit(0);
  }
  return child;
}

TEST(Guard, KillsKnownProcessEvenWhenStopped) {
  const auto child = idle_child();
  const auto known = read_process_identity(child);
  ASSERT_TRUE(known);
  EXPECT_TRUE(is_alive(*known));
  ::kill(child, SIGSTOP);
  EXPECT_TRUE(kill_process(*known, std::chrono::seconds(5)));
  EXPECT_FALSE(is_alive(*known)) << "a zombie is dead";
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
}

TEST(Guard, NeverKillsLaterProcessWithSamePid) {
  const auto child = idle_child();
  auto another = read_process_identity(child);
  ASSERT_TRUE(another);
  ++another->started;
  EXPECT_TRUE(kill_process(*another, std::chrono::seconds(1)));
  auto of_another_boot = read_process_identity(child);
  of_another_boot->boot += "x";
  EXPECT_TRUE(kill_process(*of_another_boot, std::chrono::seconds(1)));
  EXPECT_EQ(::waitpid(child, nullptr, WNOHANG), 0) << "it lives";
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

/// The parent of a program may reap it while the guard reads its state.
TEST(Guard, HandlesProcessThatEndsWhileInspected) {
  for (int i = 0; i < 500; ++i) {
    const auto child = idle_child();
    const auto known = read_process_identity(child);
    std::thread reaper([child, i] {
      ::usleep(static_cast<useconds_t>(i % 100));
      ::kill(child, SIGKILL);
      ::waitpid(child, nullptr, 0);
    });
    while (read_process_identity(child)) {
    }
    EXPECT_TRUE(known && wait_for_end(*known, std::chrono::seconds(5)));
    reaper.join();
  }
}

TEST(NotifySocket, NotifiesListener) {
  const tests::TestFolder folder;
  const auto path = folder / "notify";
  const Descriptor listener(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  ASSERT_EQ(::bind(listener.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  auto socket = NotifySocket::at(path);
  ASSERT_TRUE(socket);
  socket->notify("READY=1");
  char heard[64];
  const auto size = ::recv(listener.number(), heard, sizeof heard, MSG_DONTWAIT);
  ASSERT_GT(size, 0);
  EXPECT_EQ(std::string(heard, static_cast<std::size_t>(size)), "READY=1");
}

TEST(NotifySocket, IgnoresMissingListener) {
  auto socket = NotifySocket::at("@gyrotherm-nobody-listens");
  ASSERT_TRUE(socket);
  socket->notify("WATCHDOG=1");
  EXPECT_FALSE(NotifySocket::at(std::string(200, 'x')));
  EXPECT_FALSE(NotifySocket::at(""));
}

}  // namespace
}  // namespace gyrotherm::watchdog
