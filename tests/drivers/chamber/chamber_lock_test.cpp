// SPDX-License-Identifier: Apache-2.0
/// One program drives a chamber.
#include "drivers/chamber/chamber_lock.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <functional>

#include "core/process.hpp"

namespace gyrotherm::drivers {
namespace {

/// A place of this process alone, its lock files in a folder that goes when the test ends.
class LockOfItsOwn : public ::testing::Test {
 protected:
  LockOfItsOwn() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    place = fmt::format("test-{}-{}", test->name(), ::getpid());
  }
  ~LockOfItsOwn() override {
    std::error_code error;
    for (const auto* folder : {"/run/gyrotherm", "/run/lock/gyrotherm-0", "/tmp/gyrotherm-0"})
      std::filesystem::remove(fmt::format("{}/{}.lock", folder, place), error);
  }
  std::string place;
};
using ChamberLockTest = LockOfItsOwn;

/// A process that does this and waits to be killed.
class Child {
 public:
  explicit Child(const std::function<bool()>& work) {
    int ready[2];
    EXPECT_EQ(::pipe(ready), 0);
    pid_ = ::fork();
    if (pid_ == 0) {
      [[maybe_unused]] const auto told = ::write(ready[1], work() ? "y" : "n", 1);
      for (;;) ::pause();
    }
    char answer = 0;
    EXPECT_EQ(::read(ready[0], &answer, 1), 1);
    EXPECT_EQ(answer, 'y');
    ::close(ready[0]), ::close(ready[1]);
  }
  ~Child() { end(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  void end() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(std::exchange(pid_, -1), nullptr, 0);
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
};

TEST_F(ChamberLockTest, ASecondIsRefusedAndToldWhoHoldsIt) {
  const auto first = ChamberLock::take(place, "/data/first.db");
  ASSERT_TRUE(first) << text(first.error());
  const auto second = ChamberLock::take(place, "/data/second.db");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, FaultKind::refused);
  const auto words = fmt::format("process {} of {}, record /data/first.db", ::getpid(), user_in_words(::getuid()));
  EXPECT_EQ(second.error().what, "another program drives it: " + words);
  const auto holder = ChamberLock::holder(place);
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->words, words);
  EXPECT_EQ(holder->pid, ::getpid());
  EXPECT_EQ(holder->uid, ::getuid());
}

TEST_F(ChamberLockTest, IsFreeOnceItsHolderHasLetGo) {
  { ASSERT_TRUE(ChamberLock::take(place, "a.db")); }
  EXPECT_FALSE(ChamberLock::holder(place));
  EXPECT_TRUE(ChamberLock::take(place, "b.db"));
}

TEST_F(ChamberLockTest, OneThatAKilledProgramLeftIsNoObstacle) {
  Child child([&] {
    static auto taken = ChamberLock::take(place, "dead.db");
    return taken.has_value();
  });
  EXPECT_FALSE(ChamberLock::take(place, "later.db")) << "while it lives";
  EXPECT_EQ(ChamberLock::holder(place)->pid, child.pid());
  child.end();
  EXPECT_TRUE(ChamberLock::take(place, "later.db"));
}

TEST_F(ChamberLockTest, ManyWhoAskDoNotKeepOthersFromBeingTold) {
  const auto lock = ChamberLock::take(place, "a.db");
  ASSERT_TRUE(lock);
  for (int i = 0; i < 6000; ++i) {
    const auto owner = owner_of_name(place);
    ASSERT_TRUE(owner);
    if (i % 200 == 0) lock->dismiss_callers();
  }
  EXPECT_EQ(owner_of_name(place)->pid, ::getpid());
}

/// A stranger who takes the name and does not answer who it is.
bool squat(const std::string& place) {
  const auto name = "gyrotherm-chamber/" + place;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path + 1);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return ::setuid(65534) == 0 && ::bind(socket, reinterpret_cast<const sockaddr*>(&address), size) == 0;
}

TEST_F(ChamberLockTest, AStrangerWhoHoldsItIsNamedWithUserAndProcess) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be somebody else, and look into other processes";
  const Child stranger([&] { return squat(place); });
  const auto refused = ChamberLock::take(place, "mine.db");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().what,
            fmt::format("another program drives it: process {} of {}", stranger.pid(), user_in_words(65534)));
}

/// With a /run of its own, of which the machine sees nothing.
bool in_a_run_of_its_own() {
  return ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
         ::mount("none", "/run", "tmpfs", 0, nullptr) == 0;
}

TEST_F(ChamberLockTest, AFolderThatIsNotTheUsersOwnIsNotUsed) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can make another user's folder";
  constexpr int kSkipped = 77;
  for (const bool foreign : {true, false}) {
    const auto child = ::fork();
    if (child == 0) {
      if (!in_a_run_of_its_own()) ::_exit(kSkipped);
      constexpr const char* kFolder = "/run/gyrotherm";
      std::filesystem::create_directory(kFolder);
      const bool prepared = (foreign ? ::chown(kFolder, 65534, 65534) : ::chmod(kFolder, 01777)) == 0;
      const bool taken = ChamberLock::take(place, "a.db").has_value();
      ::_exit(prepared && taken && std::filesystem::is_empty(kFolder) ? 0 : 1);
    }
    int ended = 0;
    ::waitpid(child, &ended, 0);
    if (WEXITSTATUS(ended) == kSkipped) GTEST_SKIP() << "this needs a mount namespace";
    EXPECT_EQ(ended, 0) << (foreign ? "foreign" : "writable");
  }
}

TEST(ChamberPlace, IsOneHoweverItsLineIsWritten) {
  const auto place = [](const char* line) { return chamber_place(parse_line(line).value(), 502, 3); };
  EXPECT_EQ(place("tcp://10.0.0.7:502"), "tcp-10.0.0.7-502-3");
  EXPECT_EQ(place("10.0.0.7"), place("tcp://10.0.0.7:502"));
  EXPECT_NE(place("10.0.0.7"), place("10.0.0.8"));
  EXPECT_NE(place("tcp://10.0.0.7:502"), place("tcp://10.0.0.7:503"));
  EXPECT_EQ(place("serial:/dev/ttyS9?9600,7O1"), place("serial:/dev/ttyS9"));
  const auto link_name = std::filesystem::temp_directory_path() / fmt::format("test-by-id-{}", ::getpid());
  std::filesystem::create_symlink("/dev/null", link_name);
  EXPECT_EQ(chamber_place(SerialLine{link_name.string(), {}}, 502, 3), "serial-dev-null");
  std::filesystem::remove(link_name);
}

TEST(ChamberPlace, OfEveryAddressOfThisMachineIsTheSame) {
  const auto place = [](const char* host) { return chamber_place(TcpLine{host, 502}, 502, 1); };
  for (const auto* host : {"0.0.0.0", "127.0.0.1", "127.1.2.3"}) EXPECT_EQ(place(host), "tcp-this.machine-502-1");
  EXPECT_EQ(chamber_place(parse_line("tcp://localhost:502").value(), 502, 1), "tcp-this.machine-502-1");
  EXPECT_EQ(place("198.51.100.7"), "tcp-198.51.100.7-502-1");
}

TEST(ChamberPlace, OfUnitsBehindOneAddressAreSeveral) {
  const auto line = parse_line("10.0.0.7").value();
  EXPECT_NE(chamber_place(line, 502, 1), chamber_place(line, 502, 2));
}

TEST(ChamberName, OfALongPlaceIsItsOwnToo) {
  const std::string long_place(300, 'x');
  const auto taken = take_name(long_place + "1");
  ASSERT_TRUE(taken);
  EXPECT_TRUE(take_name(long_place + "2"));
  EXPECT_FALSE(take_name(long_place + "1"));
}

}  // namespace
}  // namespace gyrotherm::drivers
