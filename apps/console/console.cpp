// SPDX-License-Identifier: Apache-2.0
#include "apps/console/console.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "apps/console/interrupt.hpp"
#include "core/clock.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono::steady_clock;

constexpr auto kPlainPanelEvery = std::chrono::milliseconds(60000);

bool may_move() {
  const char* terminal = std::getenv("TERM");
  const bool is_dumb = terminal == nullptr || *terminal == '\0' || std::string_view(terminal) == "dumb";
  return ::isatty(STDERR_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr && !is_dumb;
}

/// Returns ", 12 min 03 s left", or nothing until 1 % and two seconds have passed.
std::string time_left(double fraction, steady_clock::duration spent) {
  if (fraction < 0.01 || spent < std::chrono::seconds(2) || fraction >= 1) return {};
  const auto seconds = std::chrono::duration<double>(spent).count() * (1 - fraction) / fraction;
  return ", " + spoken(from_seconds(seconds)) + " left";
}

struct TerminalSize {
  std::size_t columns = 80, rows = 24;
};

/// Returns the size of the terminal on stderr, or 80 × 24.
TerminalSize terminal_size() {
  winsize size{};
  TerminalSize found;
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0) return found;
  if (size.ws_col > 0) found.columns = size.ws_col;
  if (size.ws_row > 0) found.rows = size.ws_row;
  return found;
}

}  // namespace

Console::Console() : out_(STDOUT_FILENO), err_(STDERR_FILENO), moving_(may_move()) {}

void Console::never_wait() {
  out_.never_wait();
  err_.never_wait();
}

/// Removes control characters: text from instruments and files must not control the terminal.
void Console::put_message(std::string words) {
  const auto text = plain(words, Blanks::kept);
  err_.say([&](std::size_t dropped) {
    return dropped == 0 ? text : fmt::format("({} messages could not be shown in time)\n{}", dropped, text);
  });
}

void Console::say(std::string_view message) {
  if (!quiet) put_message(fmt::format("{}\n", message));
}

void Console::detail(std::string_view message) {
  if (verbose) say(message);
}

void Console::data(std::string_view text) {
  fact([&](std::size_t) { return plain(text, Blanks::kept); });
}

/// Erases the panel first, because stdout may be the same terminal.
void Console::fact(const std::function<std::string(std::size_t missed)>& text) {
  if (moving_) put_message({});
  out_.say(text);
}

void Console::complain(std::string_view program, const Fault& fault) {
  put_message(fmt::format("{}: {}\n", program, text(fault)));
}

void Console::progress(std::string_view stage, double fraction) {
  if (quiet) return;
  const auto now = steady_clock::now();
  const bool new_stage = stage != stage_;
  if (new_stage) {
    stage_ = stage;
    stage_began_ = now;
  }
  const auto rest = moving_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(10000);
  if (!new_stage && now - last_shown_ < rest && fraction < 1) return;
  if (new_stage && !moving_ && fraction >= 1) return;
  last_shown_ = now;
  auto line = fmt::format("{}: {:3.0f} %{}", stage_, 100 * std::clamp(fraction, 0.0, 1.0),
                          time_left(fraction, now - stage_began_));
  if (moving_)
    err_.draw({std::move(line)});
  else
    put_message(line + "\n");
}

void Console::panel(const std::function<std::vector<std::string>()>& lines, bool at_once) {
  if (quiet) return;
  const auto now = steady_clock::now();
  const auto rest = moving_ ? std::chrono::milliseconds(100) : kPlainPanelEvery;
  if (!(at_once && !moving_) && now - last_shown_ < rest) return;
  last_shown_ = now;
  auto shown = lines();
  if (!moving_) return put_message(shown.front() + "\n");
  const auto [columns, rows] = terminal_size();
  // Lines that have scrolled off the top cannot be redrawn.
  if (shown.size() >= rows) shown.resize(std::max<std::size_t>(rows, 2) - 1);
  for (auto& line : shown) line = cut_to(plain(line), columns);
  err_.draw(std::move(shown));
}

ProgressSink Console::sink() {
  return [this](std::string_view stage, double fraction) {
    progress(stage, fraction);
    return !interrupted();
  };
}

}  // namespace gyrotherm::app
