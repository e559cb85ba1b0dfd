// SPDX-License-Identifier: Apache-2.0
#include "core/program_start.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>

#include "core/file.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm {
namespace {

/// Redirects a standard stream for the lifetime of the object.
class RedirectedStream {
 public:
  RedirectedStream(std::FILE* stream, int to) : stream_(stream), before_(::dup(::fileno(stream))) {
    std::fflush(stream_);
    ::dup2(to, ::fileno(stream_));
  }
  ~RedirectedStream() {
    ::dup2(before_, ::fileno(stream_));
    ::close(before_);
    std::clearerr(stream_);
  }
  RedirectedStream(const RedirectedStream&) = delete;
  RedirectedStream& operator=(const RedirectedStream&) = delete;

 private:
  std::FILE* stream_;
  int before_;
};

TEST(StandardStreams, DistinguishFullDiskFromClosedPipe) {
  const std::string long_text(100'000, '.');
  const Descriptor full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  ::close(ends[0]);
  const Descriptor without_reader(ends[1]);
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  for (const auto* descriptor : {&full, &without_reader}) {
    const RedirectedStream err(stderr, descriptor->number());
    write_to_stderr(long_text);
  }
  for (const auto& text : {std::string("."), long_text}) {
    Result<void> on_full, on_closed;
    {
      const RedirectedStream out(stdout, full.number());
      on_full = write_to_stdout(text);
    }
    {
      const RedirectedStream out(stdout, without_reader.number());
      on_closed = write_to_stdout(text);
    }
    ASSERT_FALSE(on_full) << text.size() << " bytes";
    EXPECT_EQ(on_full.error().kind, FaultKind::storage);
    EXPECT_TRUE(on_closed) << text.size() << " bytes";
  }
  std::signal(SIGPIPE, before);
}

TEST(ObjectionTo, RejectsInvalidNumbers) {
  for (const auto* good : {"0", "-3", "9223372036854775807"}) EXPECT_EQ(value_refusal_reason(good, "INT"), "") << good;
  for (const auto* good : {"0", "18446744073709551615"}) EXPECT_EQ(value_refusal_reason(good, "UINT"), "") << good;
  for (const auto* good : {"0", "-12.5", "1e-3", ".5", "5."})
    EXPECT_EQ(value_refusal_reason(good, "FLOAT"), "") << good;
  for (const auto* kind : {"INT", "UINT", "FLOAT"})
    for (const auto* bad : {"", " 1", "1 ", "+1", "0x10", "1e999", "nan", "inf", "-inf", "one", "1,5", "1\n"})
      EXPECT_NE(value_refusal_reason(bad, kind), "") << kind << " \"" << bad << '"';
  EXPECT_NE(value_refusal_reason("1.5", "INT"), "");
  EXPECT_NE(value_refusal_reason("-1", "UINT"), "");
  EXPECT_NE(value_refusal_reason("18446744073709551616", "UINT"), "");
}

TEST(ObjectionTo, RejectsEmptyValueOfAnyKind) {
  EXPECT_NE(value_refusal_reason("", "RIG"), "");
  EXPECT_EQ(value_refusal_reason(" nan", "RIG"), "");
}

TEST(CommandRefusalReason, SuggestsNearestOrAllCommands) {
  const std::string known[] = {"rigs", "units"};
  EXPECT_EQ(command_refusal_reason("rigs", known), "");
  EXPECT_EQ(command_refusal_reason("--json", known), "");
  EXPECT_EQ(command_refusal_reason("rigz", known), "\"rigz\" is not a command. Did you mean \"rigs\"?");
  EXPECT_EQ(command_refusal_reason("calibrations", known), "\"calibrations\" is not one of the commands rigs, units");
}

TEST(MisspeltCommandReason, IgnoresFilesAndForeignWords) {
  const std::string known[] = {"sign", "verify"};
  EXPECT_EQ(misspelt_command_reason("verfy", "report", known),
            "\"verfy\" is not a command of report. Did you mean \"verify\"?");
  for (const auto* other : {"verify", "random.db", "--verfy"})
    EXPECT_EQ(misspelt_command_reason(other, "report", known), "") << other;
  const tests::TestFolder folder;
  const std::string near_file = folder / "sing";
  ASSERT_TRUE(replace_text_file(near_file, ""));
  const std::string known_paths[] = {folder / "sign"};
  EXPECT_EQ(misspelt_command_reason(near_file, "report", known_paths), "");
}

TEST(PlainErrorMessage, NamesValueAndPermittedValues) {
  EXPECT_EQ(plain_error_message("--as: C not in {libsvm,c}"),
            "--as: \"C\" is not one of libsvm, c; did you mean \"c\"?");
  EXPECT_EQ(plain_error_message("--as: excel not in {csv,netcdf}"), "--as: \"excel\" is not one of csv, netcdf");
  EXPECT_EQ(plain_error_message("--only:  not in {clock,disk}"), "--only: \"\" is not one of clock, disk");
  EXPECT_EQ(plain_error_message("--by: a: b not in {x,y} not in {one,two}"),
            "--by: \"a: b not in {x,y}\" is not one of one, two");
}

TEST(PlainErrorMessage, NamesRepeatedOption) {
  EXPECT_EQ(plain_error_message("--rig: At Most 1 required but received 2"), "--rig is given 2 times, expected once");
  EXPECT_EQ(plain_error_message("--as: At Most 1 required but received 12"), "--as is given 12 times, expected once");
  EXPECT_EQ(plain_error_message("--pace: 1 required FLOAT:FLOAT in [0.01 - 100] missing"),
            "--pace: its value is missing");
  EXPECT_EQ(plain_error_message("--days-later: Value 1.5 not in range 0 to 36500"),
            "--days-later: 1.5 is not a whole number");
}

TEST(PlainErrorMessage, TellsRangeFromInvalidNumber) {
  const std::string range = " not in range -100.000000 to 150.000000";
  EXPECT_EQ(plain_error_message("--ambient: Value 293" + range), "--ambient: 293 is outside -100 to 150");
  EXPECT_EQ(plain_error_message("--ambient: Value 20 °C" + range), "--ambient: \"20 °C\" is not an accepted number");
  EXPECT_EQ(plain_error_message("--ambient: Value 20,5" + range),
            "--ambient: \"20,5\" is not an accepted number; it has a decimal comma, write 20.5");
  EXPECT_EQ(plain_error_message("--ambient: Value 1,000,0" + range),
            "--ambient: \"1,000,0\" is not an accepted number");
}

}  // namespace
}  // namespace gyrotherm
