// SPDX-License-Identifier: Apache-2.0
#include "core/child_process.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>

namespace gyrotherm {
namespace {

constexpr Duration kTimeout = std::chrono::seconds(30);

Result<std::string> shell_output(const std::string& script, Duration timeout = kTimeout) {
  return read_program_output({"/bin/sh", "-c", script}, timeout);
}

TEST(ReadProgramOutput, ReturnsOnlyStdout) {
  EXPECT_EQ(shell_output("echo 1; echo a warning >&2; echo 2").value(), "1\n2\n");
  EXPECT_EQ(shell_output("exec 2>&-; echo 1; sleep 0.1; echo 2").value(), "1\n2\n") << "stderr was closed first";
}

TEST(ReadProgramOutput, ReturnsWholeOutputWhenBothPipesAreFull) {
  constexpr std::size_t kSize = 300'000;  // bytes, more than a pipe's buffer
  const auto write = "head -c " + std::to_string(kSize) + " /dev/zero";
  EXPECT_EQ(shell_output(write + " >&2; " + write + "; " + write + " >&2").value().size(), kSize);
}

TEST(ReadProgramOutput, FailsWithMessageOfProgram) {
  const auto refused = shell_output("echo half an answer; echo no server >&2; exit 4");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::refused);
  EXPECT_EQ(refused.error().what, "ended with 4: no server");
  EXPECT_EQ(shell_output("echo no server; exit 3").error().what, "ended with 3: no server") << "message on stdout";
  EXPECT_EQ(shell_output("kill -9 $$").error().what, "ended with 137: ");
}

TEST(ReadProgramOutput, FailsIfOutputIsTooLong) {
  const auto limited = [](const std::string& script) {
    return read_program_output({"/bin/sh", "-c", script}, kTimeout, 1000);
  };
  for (const char* script : {"exec yes", "exec yes >&2", "head -c 1001 /dev/zero; exec sleep 60",
                             "head -c 600 /dev/zero; head -c 600 /dev/zero >&2"}) {
    const auto refused = limited(script);
    ASSERT_FALSE(refused) << script;
    EXPECT_EQ(refused.error().kind, FaultKind::refused) << script;
    EXPECT_EQ(refused.error().where, "/bin/sh");
  }
  EXPECT_EQ(limited("head -c 1000 /dev/zero").value().size(), 1000u);
}

TEST(ReadProgramOutput, FailsAfterTimeout) {
  const auto late = shell_output("exec sleep 60", std::chrono::milliseconds(100));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().kind, FaultKind::timeout);
}

TEST(ReadProgramOutput, FailsAfterTimeoutIfOnlyOutputEnds) {
  const auto printed = read_program_output({"sh", "-c", "echo a; exec sleep 60 >&- 2>&-"}, std::chrono::seconds(1));
  ASSERT_FALSE(printed);
  EXPECT_EQ(printed.error().kind, FaultKind::timeout);
}

TEST(ReadProgramOutput, NamesMissingProgram) {
  const auto none = read_program_output({"/nowhere/program"}, kTimeout);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().where, "/nowhere/program");
}

TEST(Start, GivesProgramGroupOfItsOwnOnRequest) {
  for (const bool has_own_group : {false, true}) {
    const auto child = start({"sleep", "60"}, {.has_own_group = has_own_group});
    ASSERT_TRUE(child);
    EXPECT_EQ(::getpgid(*child), has_own_group ? *child : ::getpgrp());
    ::kill(*child, SIGKILL);
    EXPECT_EQ(wait_for(*child), 128 + SIGKILL);
  }
}

}  // namespace
}  // namespace gyrotherm
