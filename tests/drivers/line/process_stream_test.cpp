// SPDX-License-Identifier: Apache-2.0
/// Tests of well-behaved and misbehaving programs. Each affects only its own line and leaves nothing behind.
#include "drivers/line/process_stream.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/deadline.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/slept.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

ProgramCommand shell(const std::string& script) { return {.words = {"/bin/sh", "-c", script}}; }

Result<void> say(ByteStream& line, const std::string& text) {
  return line.write(std::as_bytes(std::span(text)), 500ms);
}

/// Reads to the end of a line, or returns the fault.
Result<std::string> hear(ByteStream& line, Duration within = 5s) {
  std::string text;
  const Deadline deadline(within);
  while (!text.ends_with('\n')) {
    std::array<std::byte, 256> some{};
    const auto size = line.read(some, deadline.left());
    if (!size) return failure(size.error());
    text.append(reinterpret_cast<const char*>(some.data()), *size);
  }
  return text;
}

/// Returns whether a process that is not a child of this one ends soon. Its parent may not have waited for it yet.
bool is_gone(pid_t process) {
  const auto runs = [&] {
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::string number, name, state;
    return (file >> number >> name >> state) && state != "Z";
  };
  for (const Deadline deadline(5s); !deadline.has_passed(); std::this_thread::sleep_for(10ms))
    if (!runs()) return true;
  return false;
}

pid_t number_in(const std::string& file) {
  pid_t number = 0;
  std::ifstream(file) >> number;
  return number;
}

TEST(ProcessStream, ExchangesLinesWithProgram) {
  ProcessStream line({.words = {"cat"}});
  ASSERT_TRUE(say(line, "hello\n"));
  EXPECT_EQ(hear(line).value(), "hello\n");
}

TEST(ProcessStream, DoesNotUseShell) {
  ProcessStream line({.words = {"echo", "$HOME; *"}});
  EXPECT_EQ(hear(line).value(), "$HOME; *\n");
}

TEST(ProcessStream, RunsInItsFolderAndHasNoOpenFileOfOurs) {
  const tests::TestFolder folder;
  const std::string script =
      "for i in 3 4 5 6 7 8 9 10 11 12; do [ -e /proc/$$/fd/$i ] && echo open $i; done; echo none, $(pwd -P)";
  ProcessStream line({.words = {"/bin/sh", "-c", script}, .folder = folder / ""});
  EXPECT_EQ(hear(line).value(), "none, " + std::filesystem::canonical(folder / ".").string() + "\n");
}

TEST(ProcessStream, ReportsExitCodeAndLastOutput) {
  ProcessStream line(shell("echo first >&2; echo no such port >&2; exit 3"));
  const auto ended = hear(line);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, FaultKind::disconnected);
  EXPECT_EQ(ended.error().what, "the program ended with exit code 3; its last output was \"no such port\"");
}

TEST(ProcessStream, ReportsSignal) {
  ProcessStream line(shell("kill -SEGV $$"));
  EXPECT_EQ(hear(line).error().what, "the program was terminated by signal 11");
}

TEST(ProcessStream, RestartsProgramAndRestsAfterSecondEnd) {
  const tests::TestFolder folder;
  const auto starts = folder / "starts";
  ProcessStream line(shell("echo . >> " + starts + "; exit 1"));
  EXPECT_EQ(hear(line).error().what, "the program ended with exit code 1");
  EXPECT_EQ(hear(line).error().what, "the program ended with exit code 1");
  const auto rests = hear(line).error().what;
  EXPECT_TRUE(rests.starts_with("the program ended with exit code 1; next try in 0.")) << rests;
  for (int i = 0; i < 1000; ++i) (void)hear(line);
  std::ifstream file(starts);
  int count = 0;
  for (std::string dot; std::getline(file, dot);) ++count;
  EXPECT_LE(count, 4) << "it is not started again and again";
}

TEST(ProcessStream, NamesMissingProgram) {
  ProcessStream line({.words = {"./no-such-program"}});
  const auto none = hear(line);
  EXPECT_EQ(text(none.error()), "./no-such-program: cannot be run: No such file or directory");
}

TEST(ProcessStream, SilenceIsATimeout) {
  ProcessStream line(shell("sleep 1000"));
  EXPECT_EQ(hear(line, 100ms).error().kind, FaultKind::timeout);
}

TEST(ProcessStream, EndsProgramThatDoesNotReadItsInput) {
  ProcessStream line(shell("sleep 1000"));
  const std::string much(1 << 20, 'x');
  Result<void> sent;
  for (int i = 0; i < 8 && sent; ++i) sent = line.write(std::as_bytes(std::span(much)), 50ms);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().what, "the program did not read its input for 0.050 s and was stopped");
}

TEST(ProcessStream, DrainsErrorOutput) {
  ProcessStream line(shell("head -c 1000000 /dev/zero | tr '\\0' 'x' >&2; echo done"));
  EXPECT_EQ(hear(line).value(), "done\n");
}

TEST(ProcessStream, AcceptsProgramThatEndsByItself) {
  const tests::TestFolder folder;
  const auto last = folder / "last";
  {
    ProcessStream line(shell("echo here; read word; echo ended > " + last));
    EXPECT_EQ(hear(line).value(), "here\n");
  }
  std::string word;
  std::ifstream(last) >> word;
  EXPECT_EQ(word, "ended") << "its input was closed, and it had time";
}

TEST(ProcessStream, KillsProgramThatDoesNotEnd) {
  const tests::TestFolder folder;
  const auto file = folder / "child";
  const tests::SleepMeter meter;
  {
    ProcessStream line(
        shell("trap '' HUP INT TERM; sleep 1000 & echo $! > " + file + "; echo here; while :; do sleep 1; done"));
    EXPECT_EQ(hear(line).value(), "here\n");
  }
  EXPECT_LT(meter.slept(), 4s);
  EXPECT_TRUE(is_gone(number_in(file))) << "its own children too";
}

TEST(ProcessStream, KillsChildrenOfEndedProgram) {
  const tests::TestFolder folder;
  const auto file = folder / "child";
  ProcessStream line(shell("sleep 1000 & echo $! > " + file + "; echo here; read word; exit 1"));
  EXPECT_EQ(hear(line).value(), "here\n");
  ASSERT_TRUE(say(line, "go\n"));
  for (const Deadline deadline(5s); !deadline.has_passed();)
    if (const auto next = hear(line, 100ms); !next && next.error().kind == FaultKind::disconnected) break;
  EXPECT_TRUE(is_gone(number_in(file))) << "although it holds the line open";
}

TEST(ProcessStream, KillsStoppedProgram) {
  const tests::TestFolder folder;
  const auto file = folder / "self";
  {
    ProcessStream line(shell("echo $$ > " + file + "; echo here; kill -STOP $$"));
    EXPECT_EQ(hear(line).value(), "here\n");
  }
  EXPECT_TRUE(is_gone(number_in(file)));
}

TEST(FindProgram, SearchesPathAndFolder) {
  const tests::TestFolder folder;
  EXPECT_TRUE(find_program({.words = {"sh"}}).value().ends_with("/sh"));
  EXPECT_EQ(find_program({.words = {"no-such-program-anywhere"}}).error().what, "program not found in PATH");
  const auto file = folder / "driver";
  std::ofstream(file) << "#!/bin/sh\n";
  const ProgramCommand command{.words = {"./driver"}, .folder = folder / ""};
  EXPECT_EQ(find_program(command).error().what, "is not a program that this user may run");
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  EXPECT_TRUE(find_program(command));
}

}  // namespace
}  // namespace gyrotherm::drivers
