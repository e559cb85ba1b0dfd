#include "app/console.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "app/interrupt.hpp"
#include "core/clock.hpp"

namespace gyrotherm {
namespace {

using std::chrono::steady_clock;

constexpr auto kPlainPanelEvery = std::chrono::milliseconds(60000);

/// What cannot be written is dropped: a closed log must not end a run, as fmt::print would.
void put(std::FILE* file, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), file);
  std::fflush(file);
}

bool may_move() { return ::isatty(STDERR_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr; }

/// "12 min 03 s left", or nothing while there is nothing to go by.
std::string time_left(double fraction, steady_clock::duration spent) {
  if (fraction < 0.01 || spent < std::chrono::seconds(2) || fraction >= 1) return {};
  const auto seconds = std::chrono::duration<double>(spent).count() * (1 - fraction) / fraction;
  return ", " + spoken(from_seconds(seconds)) + " left";
}

/// Of the terminal behind stderr.
std::size_t columns() {
  constexpr std::size_t kUsual = 80;
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

/// The first characters of a line: one that wraps would leave its rest on the screen.
std::string cut_to(const std::string& line, std::size_t width) {
  std::size_t characters = 0;
  for (std::size_t i = 0; i < line.size(); ++i)
    if ((static_cast<unsigned char>(line[i]) & 0xC0) != 0x80 && characters++ == width) return line.substr(0, i);
  return line;
}

}  // namespace

Console::Console() : moving_(may_move()) {}

void Console::clear_line() {
  if (lines_open_ > 1) put(stderr, fmt::format("\033[{}A", lines_open_ - 1));
  if (lines_open_ > 0) put(stderr, "\r\033[J");
  lines_open_ = 0;
}

void Console::say(std::string_view message) {
  if (quiet) return;
  clear_line();
  put(stderr, fmt::format("{}\n", message));
}

void Console::detail(std::string_view message) {
  if (verbose) say(message);
}

void Console::data(std::string_view text) {
  clear_line();
  put(stdout, text);
}

void Console::complain(const Fault& fault) {
  clear_line();
  put(stderr, fmt::format("gyrotherm: {}\n", text(fault)));
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
  const auto line = fmt::format("{}: {:3.0f} %{}", stage_, 100 * std::clamp(fraction, 0.0, 1.0),
                                time_left(fraction, now - stage_began_));
  put(stderr, moving_ ? "\r\033[K" + line : line + "\n");
  lines_open_ = moving_ ? 1 : 0;
}

void Console::panel(const std::function<std::vector<std::string>()>& lines, bool at_once) {
  if (quiet) return;
  const auto now = steady_clock::now();
  const auto rest = moving_ ? std::chrono::milliseconds(100) : kPlainPanelEvery;
  if (!(at_once && !moving_) && now - last_shown_ < rest) return;
  last_shown_ = now;
  const auto shown = lines();
  if (!moving_) return put(stderr, shown.front() + "\n");
  clear_line();
  std::string text;
  for (const auto& line : shown) text += (text.empty() ? "" : "\n") + cut_to(line, columns());
  put(stderr, text);
  lines_open_ = static_cast<int>(shown.size());
}

ProgressSink Console::sink() {
  return [this](std::string_view stage, double fraction) {
    progress(stage, fraction);
    return !interrupted();
  };
}

}  // namespace gyrotherm
