// SPDX-License-Identifier: Apache-2.0
#include "apps/console/outlet.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "apps/console/console.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "tests/support/slept.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

/// Pipe that is full and has no reader until its content is requested.
class UnreadPipe {
 public:
  UnreadPipe() {
    int ends[2];
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    reader_ = Descriptor(ends[0]);
    writer_ = Descriptor(ends[1]);
    ::fcntl(writer_.number(), F_SETFL, O_NONBLOCK);
    const std::string filling(4096, '.');
    while (::write(writer_.number(), filling.data(), filling.size()) > 0) continue;
    ::fcntl(writer_.number(), F_SETFL, 0);
  }
  [[nodiscard]] int writer() const { return writer_.number(); }
  /// Returns the text after the filling, up to and including `end`.
  [[nodiscard]] std::string read_until(const std::string& end) {
    std::string text;
    for (char bytes[4096]; !text.ends_with(end) && wait_until_ready(reader_.number(), POLLIN, Deadline(10s));) {
      const auto size = ::read(reader_.number(), bytes, sizeof bytes);
      for (ssize_t i = 0; i < size; ++i)
        if (bytes[i] != '.') text += bytes[i];
    }
    return text;
  }

 private:
  Descriptor reader_, writer_;
};

Outlet::Lines line(const std::string& text) {
  return [text](std::size_t dropped) { return dropped == 0 ? text + "\n" : fmt::format("{} -{}\n", text, dropped); };
}

TEST(Outlet, WritesInOrderBeforeNeverWait) {
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  const Descriptor reader(ends[0]), writer(ends[1]);
  Outlet outlet(writer.number());
  outlet.write_lines(line("one"));
  outlet.write_lines(line("two"));
  char bytes[16];
  EXPECT_EQ(std::string(bytes, static_cast<std::size_t>(::read(reader.number(), bytes, sizeof bytes))), "one\ntwo\n");
}

TEST(Outlet, DoesNotWaitForBlockedReader) {
  UnreadPipe pipe;
  const tests::SleepMeter meter;
  {
    Outlet outlet(pipe.writer());
    outlet.never_wait();
    for (int i = 0; i < 1000; ++i) {
      outlet.write_lines(line("a line"));
      outlet.draw({"a picture"});
    }
    EXPECT_LT(meter.slept(), 1s);
  }
  EXPECT_LT(meter.slept(), 3s) << "the destructor waits at most one second";
  // Otherwise the thread would remain blocked in a closed pipe.
  (void)pipe.read_until("a picture");
}

TEST(Outlet, ReportsFailedWriteOfThreadAfterFlush) {
  const Descriptor full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
  Outlet outlet(full.number());
  outlet.never_wait();
  outlet.write_lines(line("a line"));
  EXPECT_TRUE(outlet.flush());
  EXPECT_TRUE(outlet.has_failed());
}

TEST(Outlet, ReportsDroppedLinesWithNextAcceptedLines) {
  UnreadPipe pipe;
  Outlet outlet(pipe.writer());
  outlet.never_wait();
  const std::string kilobyte(1023, 'x');
  for (int i = 0; i < 400; ++i) outlet.write_lines(line(kilobyte));
  std::string text;
  const auto lines = [&] { return std::count(text.begin(), text.end(), '\n'); };
  while (lines() < static_cast<std::ptrdiff_t>(Outlet::kMaxWaitingBytes / 1024)) text += pipe.read_until("\n");
  outlet.write_lines(line("now"));
  while (text.find('-') == std::string::npos) text += pipe.read_until("\n");
  EXPECT_EQ(lines() - 1 + std::stol(text.substr(text.find('-') + 1)), 400);
}

TEST(Outlet, DrawsOnlyNewestPicture) {
  UnreadPipe pipe;
  Outlet outlet(pipe.writer());
  outlet.never_wait();
  for (int i = 0; i < 50; ++i) outlet.draw({fmt::format("picture {}", i)});
  const auto drawn = pipe.read_until("picture 49");
  std::size_t pictures = 0;
  for (auto at = drawn.find("picture"); at != std::string::npos; at = drawn.find("picture", at + 1)) ++pictures;
  EXPECT_LE(pictures, 2u) << "the one being written, and the newest";
  EXPECT_TRUE(drawn.ends_with("picture 49")) << drawn;
}

/// Terminal with so many lines, in the role of stderr during the lifetime of the object.
class SmallTerminal {
 public:
  SmallTerminal(unsigned short rows, const char* kind) {
    winsize size{.ws_row = rows, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
    int ours = kNoDescriptor, its = kNoDescriptor;
    EXPECT_EQ(::openpty(&ours, &its, nullptr, nullptr, &size), 0);
    reader_ = Descriptor(ours);
    const Descriptor terminal(its);
    before_ = Descriptor(::dup(STDERR_FILENO));
    ::dup2(its, STDERR_FILENO);
    const char* named = std::getenv("TERM");
    kind_before_ = named == nullptr ? "" : named;
    ::setenv("TERM", kind, 1);
    ::unsetenv("NO_COLOR");
  }
  ~SmallTerminal() {
    ::dup2(before_.number(), STDERR_FILENO);
    ::setenv("TERM", kind_before_.c_str(), 1);
  }
  SmallTerminal(const SmallTerminal&) = delete;
  SmallTerminal& operator=(const SmallTerminal&) = delete;
  /// Returns the output so far.
  [[nodiscard]] std::string shown() const {
    std::string text;
    for (char bytes[4096]; wait_until_ready(reader_.number(), POLLIN, Deadline(200ms));) {
      const auto size = ::read(reader_.number(), bytes, sizeof bytes);
      if (size <= 0) break;
      text.append(bytes, static_cast<std::size_t>(size));
    }
    return text;
  }

 private:
  Descriptor reader_, before_;
  std::string kind_before_;
};

std::vector<std::string> ten_lines() {
  std::vector<std::string> lines;
  for (int i = 0; i < 10; ++i) lines.push_back(fmt::format("line {}", i));
  return lines;
}

TEST(Console, LimitsPanelToTerminalHeight) {
  const SmallTerminal terminal(5, "xterm");
  Console console;
  ASSERT_TRUE(console.redraws());
  console.panel(ten_lines, true);
  const auto shown = terminal.shown();
  EXPECT_NE(shown.find("line 3"), std::string::npos) << shown;
  EXPECT_EQ(shown.find("line 4"), std::string::npos) << "its first line would scroll off the screen: " << shown;
}

TEST(Console, DoesNotRedrawDumbTerminal) {
  for (const char* kind : {"dumb", ""}) {
    const SmallTerminal terminal(24, kind);
    Console console;
    EXPECT_FALSE(console.redraws()) << kind;
    console.panel(ten_lines, true);
    console.progress("stage", 0.5);
    EXPECT_EQ(terminal.shown().find('\033'), std::string::npos) << kind;
  }
}

TEST(Console, IgnoresProgressAndPanelOfOtherThreads) {
  const SmallTerminal terminal(24, "xterm");
  Console console;
  std::jthread([&] {
    console.progress("background", 0.5);
    console.panel(ten_lines, true);
    console.print_message("a message");
  }).join();
  console.progress("foreground", 0.5);
  const auto shown = terminal.shown();
  EXPECT_EQ(shown.find("background"), std::string::npos) << shown;
  EXPECT_EQ(shown.find("line 0"), std::string::npos) << shown;
  EXPECT_NE(shown.find("a message"), std::string::npos) << shown;
  EXPECT_NE(shown.find("foreground"), std::string::npos) << shown;
}

TEST(Console, PrintsWholeMessagesOfSeveralThreads) {
  constexpr int kThreads = 4, kMessages = 100;
  std::string shown;
  {
    const SmallTerminal terminal(24, "xterm");
    Console console;
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < kThreads; ++thread)
      threads.emplace_back([&console, thread] {
        for (int i = 0; i < kMessages; ++i) console.print_message(fmt::format("<{}.{}>", thread, i));
      });
    std::jthread reader([&] { shown = terminal.shown(); });
    for (int i = 0; i < kMessages; ++i) console.panel(ten_lines, true);
    threads.clear();
    reader.join();
    shown += terminal.shown();
  }
  for (int thread = 0; thread < kThreads; ++thread)
    for (int i = 0; i < kMessages; ++i) {
      const auto message = fmt::format("<{}.{}>", thread, i);
      EXPECT_NE(shown.find(message), std::string::npos) << message;
    }
}

TEST(WrappedLines, AreBrokenAtBlanksOnly) {
  EXPECT_EQ(wrap_lines("one two three", 20), "one two three");
  EXPECT_EQ(wrap_lines("one two three", 7), "one two\n  three");
  EXPECT_EQ(wrap_lines("  Earth rate 10.6356 °/h removed\nnext\n", 18),
            "  Earth rate\n    10.6356 °/h\n    removed\nnext\n");
  EXPECT_EQ(wrap_lines("a very-long-word-that-fits-nowhere b", 10), "a\n  very-long-word-that-fits-nowhere\n  b");
  EXPECT_EQ(wrap_lines("name    1.5    2.5", 12), "name    1.5\n  2.5") << "columns keep their blanks within a line";
  EXPECT_EQ(wrap_lines("\n\n  \nä ö ü ß\n", 7), "\n\n  \nä ö ü ß\n") << "characters, not bytes";
  EXPECT_EQ(wrap_lines("", 5), "");
}

TEST(WrappedLines, KeepAllWords) {
  const std::string text =
      "std 1.073 → 0.08197 °/h, smaller by 0.9910 ± 0.0042; rmse 1.2 → 0.1 °/h, smaller by 1.10 ± 0.15";
  for (std::size_t width = 20; width < 100; ++width) {
    auto wrapped = wrap_lines(text, width);
    for (auto at = wrapped.find("\n  "); at != std::string::npos; at = wrapped.find("\n  "))
      wrapped.replace(at, 3, " ");
    EXPECT_EQ(wrapped, text) << width;
  }
}

}  // namespace
}  // namespace gyrotherm::app
