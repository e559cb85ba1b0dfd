// SPDX-License-Identifier: Apache-2.0
#include "apps/console/console.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "apps/console/interrupt.hpp"
#include "core/clock.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono::steady_clock;

constexpr auto kPlainPanelInterval = std::chrono::milliseconds(60000);

bool is_terminal() { return ::isatty(STDERR_FILENO) == 1; }

bool can_redraw() {
  const char* terminal = std::getenv("TERM");
  const bool is_dumb = terminal == nullptr || *terminal == '\0' || std::string_view(terminal) == "dumb";
  return is_terminal() && std::getenv("NO_COLOR") == nullptr && !is_dumb;
}

/// Returns ", 12 min 03 s left", or nothing if the time is unknown.
std::string format_time_left(std::optional<Duration> left) {
  return left ? ", " + format_duration(*left) + " left" : "";
}

struct TerminalSize {
  std::size_t columns = 80, rows = 24;
};

/// Returns the size of the terminal on a descriptor, or 80 × 24.
TerminalSize terminal_size(int descriptor) {
  winsize size{};
  TerminalSize found;
  if (::ioctl(descriptor, TIOCGWINSZ, &size) != 0) return found;
  if (size.ws_col > 0) found.columns = size.ws_col;
  if (size.ws_row > 0) found.rows = size.ws_row;
  return found;
}

/// Breaks lines that are longer than the terminal on a descriptor. Leaves the text unchanged for a pipe or a file.
std::string fit_to_terminal(std::string_view text, int descriptor) {
  if (::isatty(descriptor) != 1) return std::string(text);
  constexpr std::size_t kNarrowest = 20;
  return wrap_lines(text, std::max(terminal_size(descriptor).columns, kNarrowest));
}

}  // namespace

Console::Console() : out_(STDOUT_FILENO), err_(STDERR_FILENO), redraws_(can_redraw()) {}

void Console::never_wait() {
  out_.never_wait();
  err_.never_wait();
}

/// Removes control characters: text from instruments and files must not control the terminal.
void Console::write_message(const std::string& message) {
  const auto text = plain(message, Blanks::kept);
  const std::scoped_lock lock(err_guard_);
  err_.write_lines([&](std::size_t dropped) {
    return dropped == 0
               ? text
               : fmt::format("({} messages were dropped because the terminal was too slow)\n{}", dropped, text);
  });
}

void Console::draw(std::vector<std::string> lines) {
  const std::scoped_lock lock(err_guard_);
  err_.draw(std::move(lines));
}

void Console::print_message(std::string_view message) {
  if (!quiet) write_message(fmt::format("{}\n", fit_to_terminal(message, STDERR_FILENO)));
}

void Console::print_detail(std::string_view message) {
  if (verbose) print_message(message);
}

void Console::print(std::string_view text) {
  print_fact([&](std::size_t) { return plain(text, Blanks::kept); });
}

void Console::print_report(std::string_view text) {
  print(json ? std::string(text) : fit_to_terminal(plain(text, Blanks::kept), STDOUT_FILENO));
}

/// Erases the panel first, because stdout may be the same terminal.
void Console::print_fact(const std::function<std::string(std::size_t missed)>& text) {
  if (redraws_) write_message({});
  out_.write_lines(text);
}

void Console::print_fault(std::string_view program, const Fault& fault) {
  write_message(fit_to_terminal(fmt::format("{}: {}\n", program, text(fault)), STDERR_FILENO));
}

bool Console::can_ask() const { return ::isatty(STDIN_FILENO) == 1 && ::isatty(STDERR_FILENO) == 1; }

std::optional<std::string> Console::ask(std::string_view question) {
  write_message(std::string(question));
  std::string line;
  if (std::getline(std::cin, line)) return line;
  return std::nullopt;
}

void Console::progress(std::string_view stage, double fraction) {
  if (quiet || is_in_background() || !(verbose || is_terminal())) return;
  const auto now = steady_clock::now();
  const bool new_stage = stage != stage_;
  if (new_stage) {
    stage_ = stage;
    stage_began_ = now;
    time_left_ = {};
  }
  const auto left = time_left_.after(fraction, now - stage_began_);
  const auto interval = redraws_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(10000);
  if (!new_stage && now - last_shown_ < interval && fraction < 1) return;
  if (new_stage && !redraws_ && fraction >= 1) return;
  last_shown_ = now;
  auto line = fmt::format("{}: {:3.0f} %{}", stage_, 100 * std::clamp(fraction, 0.0, 1.0), format_time_left(left));
  if (redraws_)
    draw({truncate_line(plain(line), terminal_size(STDERR_FILENO).columns)});
  else
    write_message(line + "\n");
}

void Console::panel(const std::function<std::vector<std::string>()>& lines, bool at_once) {
  if (quiet || is_in_background()) return;
  const auto now = steady_clock::now();
  const auto interval = redraws_ ? std::chrono::milliseconds(100) : kPlainPanelInterval;
  if (!(at_once && !redraws_) && now - last_shown_ < interval) return;
  last_shown_ = now;
  auto shown = lines();
  if (!redraws_) return write_message(shown.front() + "\n");
  const auto [columns, rows] = terminal_size(STDERR_FILENO);
  // Lines that have scrolled off the top cannot be redrawn.
  if (shown.size() >= rows) shown.resize(std::max<std::size_t>(rows, 2) - 1);
  for (auto& line : shown) line = truncate_line(plain(line), columns);
  draw(std::move(shown));
}

ProgressSink Console::sink() {
  return [this](std::string_view stage, double fraction) {
    progress(stage, fraction);
    return !interrupted();
  };
}

}  // namespace gyrotherm::app
