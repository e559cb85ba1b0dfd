// SPDX-License-Identifier: Apache-2.0
/// Answers of the operator to the questions of proof tests, at a terminal and from a pipe.
#include "apps/gyrotherm/prove/operator_answer.hpp"

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <string>
#include <utility>

#include "core/child_process.hpp"
#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

bool confirms(const std::string& typed) {
  auto pipe = new_pipe();
  EXPECT_TRUE(write_all(pipe.to.number(), typed));
  pipe.to.close();
  return read_confirmation(pipe.from.number());
}

TEST(OperatorAnswer, ConfirmsOnlyByEmptyLine) {
  for (const char* typed : {"\n", "  \n", "\t\n", "\r\n", "\nstop\n"}) EXPECT_TRUE(confirms(typed)) << typed;
  for (const char* typed :
       {"stop\n", "Stop\n", "STOP\n", "stop \n", " stop\n", "no\n", "n\n", "q\n", "yes\n", "x\n", "", " ", "stop"})
    EXPECT_FALSE(confirms(typed)) << typed;
}

TEST(OperatorAnswer, IsNotTypedBeforeQuestion) {
  int person = -1, program = -1;
  ASSERT_EQ(::openpty(&person, &program, nullptr, nullptr, nullptr), 0);
  const Descriptor own(person), terminal(program);
  ASSERT_TRUE(write_all(person, "\nno"));  // one Enter ahead, and the beginning of a line
  discard_typed_input(program);
  ASSERT_TRUE(write_all(person, "stop\n"));
  EXPECT_FALSE(read_confirmation(program));
  ASSERT_TRUE(write_all(person, "stop\n"));
  discard_typed_input(program);
  ASSERT_TRUE(write_all(person, "\n"));
  EXPECT_TRUE(read_confirmation(program));
}

TEST(OperatorAnswer, FromPipeIsNotDiscarded) {
  auto pipe = new_pipe();
  ASSERT_TRUE(write_all(pipe.to.number(), "\n"));
  discard_typed_input(pipe.from.number());
  EXPECT_TRUE(read_confirmation(pipe.from.number()));
}

}  // namespace
}  // namespace gyrotherm::app
