// SPDX-License-Identifier: Apache-2.0
/// Tests that one program at a time drives a chamber.
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
#include <fstream>
#include <functional>

#include "core/process.hpp"

namespace gyrotherm::drivers {
namespace {

/// A chamber used only by this process, with lock files in a temporary folder.
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

/// A process that runs `work` and waits to be killed.
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

TEST_F(ChamberLockTest, RefusesSecondProgramAndNamesHolder) {
  const auto first = ChamberLock::take(place, "/data/first.db");
  ASSERT_TRUE(first) << text(first.error());
  const auto second = ChamberLock::take(place, "/data/second.db");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, FaultKind::refused);
  const auto words = fmt::format("process {} of {}, record /data/first.db", ::getpid(), describe_user(::getuid()));
  EXPECT_EQ(second.error().what, "driven by another program: " + words);
  const auto holder = ChamberLock::holder(place);
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->words, words);
  EXPECT_EQ(holder->pid, ::getpid());
  EXPECT_EQ(holder->uid, ::getuid());
}

TEST_F(ChamberLockTest, IsFreeAfterRelease) {
  { ASSERT_TRUE(ChamberLock::take(place, "a.db")); }
  EXPECT_FALSE(ChamberLock::holder(place));
  EXPECT_TRUE(ChamberLock::take(place, "b.db"));
}

TEST_F(ChamberLockTest, IsFreeAfterHolderWasKilled) {
  Child child([&] {
    static auto taken = ChamberLock::take(place, "dead.db");
    return taken.has_value();
  });
  EXPECT_FALSE(ChamberLock::take(place, "later.db")) << "while it lives";
  EXPECT_EQ(ChamberLock::holder(place)->pid, child.pid());
  child.end();
  EXPECT_TRUE(ChamberLock::take(place, "later.db"));
}

/// Abstract socket address of a chamber's name.
class ChamberAddress {
 public:
  explicit ChamberAddress(const std::string& place) {
    const auto name = "gyrotherm-chamber/" + place;
    address_.sun_family = AF_UNIX;
    std::copy(name.begin(), name.end(), address_.sun_path + 1);
    size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  }
  [[nodiscard]] const sockaddr* pointer() const { return reinterpret_cast<const sockaddr*>(&address_); }
  socklen_t size{};

 private:
  sockaddr_un address_{};
};

/// Returns whether the queue of the chamber's name accepts a caller, who leaves at once.
bool accepts_caller(const std::string& place) {
  const ChamberAddress address(place);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const bool is_accepted = ::connect(socket, address.pointer(), address.size) == 0;
  ::close(socket);
  return is_accepted;
}

/// Another user finds the holder only by a call: the open files of the holder are hidden.
TEST_F(ChamberLockTest, MakesSpaceInFullQueue) {
  constexpr int kMoreThanAnyQueue = 100'000, kEnough = 64;
  const auto lock = ChamberLock::take(place, "a.db");
  ASSERT_TRUE(lock);
  for (int callers = 0; accepts_caller(place); ++callers) ASSERT_LT(callers, kMoreThanAnyQueue);
  for (int i = 0; i < kEnough; ++i) lock->close_callers();
  EXPECT_TRUE(accepts_caller(place));
}

TEST_F(ChamberLockTest, ReportsHolderDespiteManyQueries) {
  const auto lock = ChamberLock::take(place, "a.db");
  ASSERT_TRUE(lock);
  for (int i = 0; i < 6000; ++i) {
    const auto owner = find_name_owner(place);
    ASSERT_TRUE(owner);
    if (i % 200 == 0) lock->close_callers();
  }
  EXPECT_EQ(find_name_owner(place)->pid, ::getpid());
}

constexpr uid_t kStranger = 65534;

/// Behaviour of the process that holds the name.
struct Squat {
  const char* what;
  bool listens;  ///< answers until its queue is full
  int callers;
};
constexpr Squat kSquats[] = {{"bound", false, 0}, {"listening", true, 0}, {"full", true, 3}};

/// Binds the name of a chamber as another user, until the process is killed.
bool squat_as(const std::string& place, const Squat& how, uid_t uid) {
  const ChamberAddress address(place);
  if (::setgid(uid) != 0 || ::setuid(uid) != 0) return false;
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  if (::bind(socket, address.pointer(), address.size) != 0 || (how.listens && ::listen(socket, 1) != 0)) return false;
  for (int i = 0; i < how.callers; ++i)
    ::connect(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0), address.pointer(), address.size);
  return true;
}

TEST_F(ChamberLockTest, IsTakenDespiteStrangerWhoHoldsItsName) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  for (const auto& how : kSquats) {
    const Child stranger([&] { return squat_as(place, how, kStranger); });
    const auto lock = ChamberLock::take(place, "mine.db");
    ASSERT_TRUE(lock) << how.what << ": " << text(lock.error());
    ASSERT_EQ(lock->unauthorised_holders().size(), 1u) << how.what;
    EXPECT_EQ(lock->unauthorised_holders()[0].words,
              fmt::format("process {} of {}", stranger.pid(), describe_user(kStranger)));
    EXPECT_EQ(ChamberLock::holder(place)->pid, ::getpid()) << how.what;
  }
}

TEST_F(ChamberLockTest, ExcludesSecondProgramWhileStrangerHoldsItsName) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  for (const auto& how : kSquats) {
    Child stranger([&] { return squat_as(place, how, kStranger); });
    const Child first([&] {
      static auto taken = ChamberLock::take(place, "first.db");
      return taken.has_value();
    });
    const auto while_it_squats = ChamberLock::take(place, "second.db");
    ASSERT_FALSE(while_it_squats) << how.what;
    EXPECT_NE(while_it_squats.error().what.find(std::to_string(first.pid())), std::string::npos);
    stranger.end();
    const auto afterwards = ChamberLock::take(place, "second.db");
    ASSERT_FALSE(afterwards) << how.what;
    EXPECT_NE(afterwards.error().what.find(std::to_string(first.pid())), std::string::npos);
  }
}

/// A folder at the path of the lock file prevents its creation.
TEST_F(ChamberLockTest, ExcludesSecondProgramByNamesAlone) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  ::unsetenv("XDG_RUNTIME_DIR");
  for (const auto* folder : {"/run/gyrotherm", "/run/lock/gyrotherm-0"})
    std::filesystem::create_directories(fmt::format("{}/{}.lock", folder, place));
  for (const auto& how : kSquats) {
    const Child stranger([&] { return squat_as(place, how, kStranger); });
    const Child first([&] {
      static auto taken = ChamberLock::take(place, "first.db");
      return taken.has_value();
    });
    const auto second = ChamberLock::take(place, "second.db");
    ASSERT_FALSE(second) << how.what;
    EXPECT_NE(second.error().what.find(std::to_string(first.pid())), std::string::npos) << text(second.error());
  }
}

/// Takes the lock as another user.
bool takes_lock_as(const std::string& place, uid_t uid) {
  return ::setgid(uid) == 0 && ::setuid(uid) == 0 && ChamberLock::take(place, "other.db").has_value();
}

TEST_F(ChamberLockTest, AcceptsLockOfRootForEveryUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  const auto lock = ChamberLock::take(place, "mine.db");
  ASSERT_TRUE(lock);
  for (const uid_t uid : {1U, 33U, 1000U, kStranger}) {
    const auto child = ::fork();
    if (child == 0) ::_exit(takes_lock_as(place, uid) ? 1 : 0);
    int ended = 0;
    ::waitpid(child, &ended, 0);
    EXPECT_EQ(ended, 0) << uid;
  }
}

/// Replaces the machine's users and groups: ada (1001) is a member of dialout, ben (1002) has gyrotherm as his primary
/// group, carl (1003) is in neither.
bool with_users_of_its_own() {
  if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return false;
  const auto lay = [](const char* over, const std::string& text) {
    const auto file = std::filesystem::temp_directory_path() / fmt::format("users-{}", ::getpid());
    std::ofstream(file) << text;
    const bool done = ::mount(file.c_str(), over, nullptr, MS_BIND, nullptr) == 0;
    std::filesystem::remove(file);
    return done;
  };
  return lay("/etc/passwd",
             "root:x:0:0::/root:/bin/sh\nada:x:1001:1001::/:/bin/sh\nben:x:1002:77::/:/bin/sh\n"
             "carl:x:1003:1003::/:/bin/sh\n") &&
         lay("/etc/group", "root:x:0:\ndialout:x:20:zoe,ada\ngyrotherm:x:77:\nadabert:x:78:carl\n");
}

TEST(ChamberUsers, AreThisUserRootAndMembersOfTheGroups) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay other users over those of the machine";
  constexpr int kSkipped = 77;
  const auto child = ::fork();
  if (child == 0) {
    if (!with_users_of_its_own()) ::_exit(kSkipped);
    const bool good = may_drive_chambers(0) && may_drive_chambers(1001) && may_drive_chambers(1002) &&
                      !may_drive_chambers(1003) && !may_drive_chambers(1004) && !may_drive_chambers(65534) &&
                      may_drive_chambers(-1) && ::setuid(1003) == 0 && may_drive_chambers(1003);
    ::_exit(good ? 0 : 1);
  }
  int ended = 0;
  ::waitpid(child, &ended, 0);
  if (WEXITSTATUS(ended) == kSkipped) GTEST_SKIP() << "this needs a mount namespace";
  EXPECT_EQ(ended, 0);
}

TEST_F(ChamberLockTest, IsHeldByAnotherUserOfTheGroups) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  constexpr int kSkipped = 77;
  struct Case {
    uid_t uid;
    bool refuses;
  };
  for (const auto& [uid, refuses] : {Case{1001, true}, Case{1002, true}, Case{1003, false}}) {
    const Child other([&] { return squat_as(place, kSquats[1], uid); });
    const auto child = ::fork();
    if (child == 0) {
      if (!with_users_of_its_own()) ::_exit(kSkipped);
      ::_exit(ChamberLock::take(place, "mine.db").has_value() != refuses ? 0 : 1);
    }
    int ended = 0;
    ::waitpid(child, &ended, 0);
    if (WEXITSTATUS(ended) == kSkipped) GTEST_SKIP() << "this needs a mount namespace";
    EXPECT_EQ(ended, 0) << uid;
  }
}

/// Mounts a private /run.
bool in_a_run_of_its_own() {
  return ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
         ::mount("none", "/run", "tmpfs", 0, nullptr) == 0;
}

TEST_F(ChamberLockTest, IgnoresFolderOfAnotherUser) {
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

TEST(ChamberPlace, DoesNotDependOnNotation) {
  const auto place = [](const char* line) { return chamber_lock_name(parse_line(line).value(), 502, 3); };
  EXPECT_EQ(place("tcp://10.0.0.7:502"), "tcp-10.0.0.7-502-3");
  EXPECT_EQ(place("10.0.0.7"), place("tcp://10.0.0.7:502"));
  EXPECT_NE(place("10.0.0.7"), place("10.0.0.8"));
  EXPECT_NE(place("tcp://10.0.0.7:502"), place("tcp://10.0.0.7:503"));
  EXPECT_EQ(place("serial:/dev/ttyS9?9600,7O1"), place("serial:/dev/ttyS9"));
  const auto link_name = std::filesystem::temp_directory_path() / fmt::format("test-by-id-{}", ::getpid());
  std::filesystem::create_symlink("/dev/null", link_name);
  EXPECT_EQ(chamber_lock_name(SerialLine{link_name.string(), {}}, 502, 3), "serial-dev-null");
  std::filesystem::remove(link_name);
}

TEST(ChamberPlace, IsEqualForEveryLocalAddress) {
  const auto place = [](const char* host) { return chamber_lock_name(TcpLine{host, 502}, 502, 1); };
  for (const auto* host : {"0.0.0.0", "127.0.0.1", "127.1.2.3"}) EXPECT_EQ(place(host), "tcp-this.machine-502-1");
  EXPECT_EQ(chamber_lock_name(parse_line("tcp://localhost:502").value(), 502, 1), "tcp-this.machine-502-1");
  EXPECT_EQ(place("198.51.100.7"), "tcp-198.51.100.7-502-1");
}

TEST(ChamberPlace, DistinguishesUnitsAtOneAddress) {
  const auto line = parse_line("10.0.0.7").value();
  EXPECT_NE(chamber_lock_name(line, 502, 1), chamber_lock_name(line, 502, 2));
}

TEST(ChamberName, IsUniqueForLongIdentifier) {
  const std::string long_place(300, 'x');
  const auto taken = bind_chamber_name(long_place + "1");
  ASSERT_TRUE(taken);
  EXPECT_TRUE(bind_chamber_name(long_place + "2"));
  EXPECT_FALSE(bind_chamber_name(long_place + "1"));
}

}  // namespace
}  // namespace gyrotherm::drivers
