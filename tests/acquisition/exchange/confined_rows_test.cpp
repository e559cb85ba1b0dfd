// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/confined_rows.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <vector>

#include "core/file.hpp"
#include "core/sanitizer.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

using Step = std::function<void()>;

const ReadingLimits kShort{
    .memory_bytes = 64 << 20, .processor_time = std::chrono::seconds(1), .silence = std::chrono::milliseconds(300)};

Result<void> read_with(
    const ReadInSteps& read, const TakeRow& take = [](const ForeignRow&) { return Result<void>(); },
    const ReadingLimits& limits = kShort) {
  return read_confined("a.nc", "the library", 2, read, take, limits);
}

/// Returns the fault for a reader that terminates with `end`.
std::string reading_fault(const std::function<void()>& end, const ReadingLimits& limits = kShort) {
  const auto read = read_with(
      [&](const TakeRow&, const Step& step) -> Result<void> {
        step();
        end();
        return {};
      },
      [](const ForeignRow&) { return Result<void>(); }, limits);
  if (read) return "";
  EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  EXPECT_EQ(read.error().where, "a.nc");
  return read.error().what;
}

volatile int sink = 0;

TEST(ConfinedRows, EqualRowsOfReader) {
  constexpr int kRows = 100'000;
  std::size_t count = 0;
  double sum = 0;
  const auto read = read_with(
      [](const TakeRow& take, const Step&) -> Result<void> {
        for (int i = 0; i < kRows; ++i) {
          const std::vector<double> numbers{1.0 * i, -0.5};
          ForeignRow row{.time = Duration(i), .numbers = numbers};
          if (i % 2 == 1) row.utc = Duration(7);
          if (auto taken = take(row); !taken) return taken;
        }
        return {};
      },
      [&](const ForeignRow& row) -> Result<void> {
        EXPECT_EQ(row.time, Duration(static_cast<std::int64_t>(count)));
        EXPECT_EQ(row.utc.has_value(), count % 2 == 1);
        sum += row.numbers[0] + row.numbers[1];
        ++count;
        return {};
      });
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(count, 100'000u);
  EXPECT_EQ(sum, 99'999.0 * 50'000 - 50'000);
}

/// A damaged file may corrupt the memory of the reader.
TEST(ConfinedRows, RefuseImpossibleTimes) {
  constexpr Duration kLeast = Duration::min(), kGreatest = Duration::max(), kYears = std::chrono::hours(24 * 3653);
  struct Case {
    Duration time{};
    std::optional<Duration> utc{};
    bool is_accepted{};
  };
  for (const auto& [time, utc, is_accepted] :
       {Case{kLeast, {}, false}, Case{kGreatest, {}, false}, Case{kYears, {}, false}, Case{-kYears, {}, false},
        Case{Duration(0), kLeast, false}, Case{Duration(0), kGreatest, false}, Case{Duration(0), Duration(-1), false},
        Case{std::chrono::hours(-1), Duration(0), true}, Case{std::chrono::hours(24 * 3652), {}, true}}) {
    int rows = 0;
    const auto read = read_with(
        [&](const TakeRow& take, const Step&) {
          const std::vector<double> numbers{1, 2};
          return take({.time = time, .utc = utc, .numbers = numbers});
        },
        [&](const ForeignRow&) {
          ++rows;
          return Result<void>();
        });
    EXPECT_EQ(read.has_value(), is_accepted) << time.count();
    EXPECT_EQ(rows, is_accepted ? 1 : 0);
    if (!read) EXPECT_EQ(read.error().where, "a.nc");
  }
}

TEST(ConfinedRows, PassOnFaultsOfReaderAndTaker) {
  const auto faulty = [](const TakeRow& take, const Step&) -> Result<void> {
    const std::vector<double> numbers{1, 2};
    for (int i = 0; i < 3; ++i)
      if (auto taken = take({.time = Duration(i), .numbers = numbers}); !taken) return taken;
    return failure(FaultKind::bad_file, "a.nc: row 3", "no time");
  };
  int rows = 0;
  const auto read = read_with(faulty, [&](const ForeignRow&) {
    ++rows;
    return Result<void>();
  });
  ASSERT_FALSE(read);
  EXPECT_EQ(text(read.error()), "a.nc: row 3: no time");
  EXPECT_EQ(rows, 3);
  const auto refused = read_with(faulty, [](const ForeignRow& row) -> Result<void> {
    return row.time == Duration(1) ? Result<void>(failure(FaultKind::bad_file, "", "too hot")) : Result<void>();
  });
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()), "a.nc: row 1: too hot");
  const auto stopped = read_with(
      faulty, [](const ForeignRow&) -> Result<void> { return failure(FaultKind::interrupted, "run.db", "stopped"); });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, FaultKind::interrupted);
}

TEST(ConfinedRows, ReturnTextOfReader) {
  const auto text_of = [](const ReadTextInSteps& read) {
    const auto found = read_text_confined("a.nc", "the library", read, kShort);
    return found ? *found : text(found.error());
  };
  EXPECT_EQ(text_of([](const Step& step) -> Result<std::string> {
              step();
              return std::string("measured\0", 9);
            }),
            std::string("measured\0", 9));
  EXPECT_EQ(text_of([](const Step&) -> Result<std::string> { return std::string(1 << 20, 'x'); }),
            std::string(1 << 16, 'x'));
  EXPECT_EQ(text_of([](const Step&) -> Result<std::string> {
              return failure(FaultKind::bad_file, "a.nc", "not a NetCDF file");
            }),
            "a.nc: not a NetCDF file");
  EXPECT_NE(text_of([](const Step&) -> Result<std::string> { std::abort(); }).find("ended by signal 6"),
            std::string::npos);
}

TEST(ConfinedRows, RefuseFileThatCrashesReader) {
  EXPECT_NE(reading_fault([] { ::raise(SIGSEGV); }), "");
  EXPECT_NE(reading_fault([] { std::abort(); }), "");
  EXPECT_NE(reading_fault([] { ::raise(SIGKILL); }).find("was ended by signal 9 (Killed)"), std::string::npos);
  EXPECT_NE(reading_fault([] { ::_exit(3); }).find("ended with exit code 3"), std::string::npos);
}

TEST(ConfinedRows, RefuseFileThatExceedsLimits) {
  EXPECT_NE(reading_fault(
                [] {
                  while (true) sink = sink + 1;
                },
                {.processor_time = std::chrono::seconds(1)})
                .find("more than 1 s of processor time"),
            std::string::npos);
  EXPECT_NE(reading_fault([] { ::sleep(60); }).find("returned no row for 0.3 s"), std::string::npos);
  if (kIsSanitizerBuild) return;
  EXPECT_NE(reading_fault([] {
              const std::vector<char> much(std::size_t{1} << 30);
              sink = much[sink];
            }).find("more than 64 MiB of memory"),
            std::string::npos);
  const auto taken = read_with([](const TakeRow&, const Step&) -> Result<void> {
    void* much = std::malloc(std::size_t{1} << 30);
    return much == nullptr ? failure(FaultKind::bad_file, "a.nc", "no memory") : Result<void>();
  });
  ASSERT_FALSE(taken) << "C code cannot write either";
}

TEST(ConfinedRows, PreventReaderFromWritingFiles) {
  const tests::TestFolder folder;
  const std::string path = folder / "written";
  std::ofstream(path) << "before";
  const Descriptor any(::open(path.c_str(), O_WRONLY)), opened(::fcntl(any.number(), F_DUPFD, 20));
  ASSERT_TRUE(opened.is_open());
  EXPECT_NE(reading_fault([&] {
              std::ofstream file(path);
              file << "after" << std::flush;
            }).find("tried to write a file"),
            std::string::npos);
  EXPECT_EQ(reading_fault([&] {
              if (::write(opened.number(), "x", 1) == 1) ::_exit(4);  // the parent's descriptor
            }),
            "");
}

/// Sends messages like those of a library that has overwritten the memory of the child.
TEST(ConfinedRows, RefuseMalformedMessages) {
  const auto garbage = [](std::string bytes) {
    return reading_fault([bytes] {
      constexpr int kLine = STDERR_FILENO + 1;
      if (::write(kLine, bytes.data(), bytes.size()) < 0) ::_exit(1);
      ::_exit(0);
    });
  };
  const std::string size_1("\x01\0\0\0\0\0\0\0", 8), huge(8, '\x7F');
  EXPECT_NE(garbage("R" + huge).find("sent an invalid message"), std::string::npos);
  EXPECT_NE(garbage("R" + size_1 + "x").find("sent an invalid message"), std::string::npos);
  EXPECT_NE(garbage("X" + size_1 + "x").find("sent an invalid message"), std::string::npos);
  EXPECT_NE(garbage("F" + size_1 + "\x7F").find("sent an invalid message"), std::string::npos);
  EXPECT_NE(garbage("E").find("ended with exit code 0"), std::string::npos);
  EXPECT_NE(garbage(""), "");
}

}  // namespace
}  // namespace gyrotherm::exchange
