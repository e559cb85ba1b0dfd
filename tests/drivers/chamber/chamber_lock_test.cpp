/// One program drives a chamber.
#include "drivers/chamber/chamber_lock.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

namespace gyrotherm {
namespace {

/// A place of this process alone; its file goes when the test ends.
struct OwnPlace {
  explicit OwnPlace(const char* name) : place(fmt::format("test-{}-{}", name, ::getpid())) {}
  ~OwnPlace() {
    std::error_code error;
    std::filesystem::remove("/run/lock/gyrotherm/" + place + ".lock", error);
  }
  OwnPlace(const OwnPlace&) = delete;
  OwnPlace& operator=(const OwnPlace&) = delete;
  std::string place;
};

TEST(ChamberLock, ASecondIsRefusedAndToldWhoHoldsIt) {
  const OwnPlace own("second");
  const auto& place = own.place;
  const auto first = ChamberLock::take(place, "/data/first.db");
  ASSERT_TRUE(first) << text(first.error());
  const auto second = ChamberLock::take(place, "/data/second.db");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, FaultKind::refused);
  EXPECT_NE(second.error().what.find(fmt::format("process {}, record /data/first.db", ::getpid())), std::string::npos)
      << second.error().what;
  EXPECT_EQ(ChamberLock::holder(place), fmt::format("process {}, record /data/first.db", ::getpid()));
}

TEST(ChamberLock, IsFreeOnceItsHolderHasLetGo) {
  const OwnPlace own("free");
  const auto& place = own.place;
  { ASSERT_TRUE(ChamberLock::take(place, "a.db")); }
  EXPECT_FALSE(ChamberLock::holder(place));
  EXPECT_TRUE(ChamberLock::take(place, "b.db"));
}

TEST(ChamberLock, OneThatAKilledProgramLeftIsNoObstacle) {
  const OwnPlace own("stale");
  const auto& place = own.place;
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const auto child = ::fork();
  if (child == 0) {
    const auto taken = ChamberLock::take(place, "dead.db");
    [[maybe_unused]] const auto told = ::write(ready[1], taken ? "y" : "n", 1);
    ::pause();
    ::_exit(0);
  }
  char answer = 0;
  ASSERT_EQ(::read(ready[0], &answer, 1), 1);
  EXPECT_EQ(answer, 'y');
  EXPECT_FALSE(ChamberLock::take(place, "later.db")) << "while it lives";
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(ChamberLock::take(place, "later.db"));
}

TEST(ChamberLock, TheSameChamberHasOnePlaceHoweverItsLineIsWritten) {
  const auto place = [](const char* line) { return chamber_place(parse_line(line).value(), 502, 3); };
  EXPECT_EQ(place("tcp://10.0.0.7:502"), "tcp-10.0.0.7-502-3");
  EXPECT_EQ(place("10.0.0.7"), place("tcp://10.0.0.7:502"));
  EXPECT_EQ(place("tcp://localhost:502"), place("tcp://127.0.0.1:502"));
  EXPECT_NE(place("10.0.0.7"), place("10.0.0.8"));
  EXPECT_NE(place("tcp://10.0.0.7:502"), place("tcp://10.0.0.7:503"));
  EXPECT_EQ(place("serial:/dev/ttyS9?9600,7O1"), place("serial:/dev/ttyS9"));
  const auto link_name = std::filesystem::temp_directory_path() / fmt::format("test-by-id-{}", ::getpid());
  std::filesystem::create_symlink("/dev/null", link_name);
  EXPECT_EQ(chamber_place(SerialLine{link_name.string(), {}}, 502, 3), "serial-dev-null");
  std::filesystem::remove(link_name);
}

TEST(ChamberLock, UnitsBehindOneAddressAreChambersOfTheirOwn) {
  const auto line = parse_line("10.0.0.7").value();
  EXPECT_NE(chamber_place(line, 502, 1), chamber_place(line, 502, 2));
}

}  // namespace
}  // namespace gyrotherm
