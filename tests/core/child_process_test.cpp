// SPDX-License-Identifier: Apache-2.0
#include "core/child_process.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace gyrotherm {
namespace {

constexpr Duration kPatience = std::chrono::seconds(30);

Result<std::string> printed_by_shell(const std::string& script, Duration within = kPatience) {
  return read_program_output({"/bin/sh", "-c", script}, within);
}

TEST(ReadProgramOutput, ReturnsOnlyStdout) {
  EXPECT_EQ(printed_by_shell("echo 1; echo a warning >&2; echo 2").value(), "1\n2\n");
  EXPECT_EQ(printed_by_shell("exec 2>&-; echo 1; sleep 0.1; echo 2").value(), "1\n2\n") << "whichever ends first";
}

TEST(ReadProgramOutput, ReturnsWholeOutputWhenBothPipesAreFull) {
  constexpr std::size_t kMuch = 300'000;
  const auto much = "head -c " + std::to_string(kMuch) + " /dev/zero";
  EXPECT_EQ(printed_by_shell(much + " >&2; " + much + "; " + much + " >&2").value().size(), kMuch);
}

TEST(ReadProgramOutput, FailsWithMessageOfProgram) {
  const auto refused = printed_by_shell("echo half an answer; echo no server >&2; exit 4");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::refused);
  EXPECT_EQ(refused.error().what, "ended with 4: no server");
  EXPECT_EQ(printed_by_shell("echo no server; exit 3").error().what, "ended with 3: no server") << "said at stdout";
  EXPECT_EQ(printed_by_shell("kill -9 $$").error().what, "ended with 137: ");
}

TEST(ReadProgramOutput, FailsAfterTimeout) {
  const auto late = printed_by_shell("exec sleep 60", std::chrono::milliseconds(100));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().kind, FaultKind::timeout);
}

TEST(ReadProgramOutput, NamesMissingProgram) {
  const auto none = read_program_output({"/nowhere/program"}, kPatience);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().where, "/nowhere/program");
}

}  // namespace
}  // namespace gyrotherm
