// SPDX-License-Identifier: Apache-2.0
#include "apps/console/outlet.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "apps/console/interrupt.hpp"
#include "core/process.hpp"

namespace gyrotherm::app {
namespace {

constexpr auto kFlushTimeout = std::chrono::seconds(1);
constexpr int kForever = -1;

/// Writes all text, and waits as long as necessary. Returns false if a write fails, or if `stops_on_interrupt` is set
/// and the user requests a stop before all text is written.
bool write_all(int descriptor, std::string_view text, bool stops_on_interrupt) {
  while (!text.empty()) {
    const auto written = ::write(descriptor, text.data(), text.size());
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {  // another process set O_NONBLOCK
      pollfd reader{descriptor, POLLOUT, 0};
      ::poll(&reader, 1, kForever);
    } else if (errno != EINTR) {
      return false;
    }
    if (stops_on_interrupt && interrupted() && !text.empty()) return false;
  }
  return true;
}

}  // namespace

/// State shared by the outlet and its thread.
struct Outlet::SharedState {
  explicit SharedState(int to) : descriptor(to) {}

  const int descriptor;
  std::mutex mutex;  ///< guards all members below
  std::condition_variable available, progress;
  std::deque<std::string> lines;
  std::size_t waiting{};  ///< bytes in `lines`
  std::size_t dropped{};  ///< since the last accepted lines
  std::optional<std::vector<std::string>> picture;
  Screen screen;  ///< state of the descriptor's terminal
  bool has_thread{}, is_writing{}, stop{}, write_failed{};

  [[nodiscard]] bool is_idle() const { return lines.empty() && !picture && !is_writing; }

  /// Removes and returns the next bytes to write: first the lines, then the picture. Requires the lock and !is_idle().
  std::string take_next() {
    if (lines.empty()) return screen.picture(*std::exchange(picture, std::nullopt));
    auto text = screen.message(lines.front());
    waiting -= lines.front().size();
    lines.pop_front();
    return text;
  }

  /// Writes the next bytes. Releases the lock while it writes.
  void write_next(std::unique_lock<std::mutex>& lock) {
    const auto text = take_next();
    is_writing = true;
    lock.unlock();
    const bool written = write_all(descriptor, text, !has_thread);
    lock.lock();
    is_writing = false;
    write_failed = write_failed || !written;
    progress.notify_all();
  }

  /// Body of the writer thread. Returns once `stop` is set and everything is written.
  void run_thread() {
    block_signals();
    std::unique_lock lock(mutex);
    for (;;) {
      available.wait(lock, [this] { return stop || !is_idle(); });
      if (is_idle()) return;
      write_next(lock);
    }
  }

  /// Wakes the writer thread, or writes everything itself if there is none. Requires the lock.
  void write_or_wake_thread(std::unique_lock<std::mutex>& lock) {
    if (has_thread) return available.notify_one();
    while (!is_idle()) write_next(lock);
  }
};

Outlet::Outlet(int descriptor) : state_(std::make_shared<SharedState>(descriptor)) {}

void Outlet::never_wait() {
  if (writer_.joinable()) return;
  state_->has_thread = true;
  writer_ = std::thread([state = state_] { state->run_thread(); });
}

void Outlet::write_lines(const Lines& lines) {
  std::unique_lock lock(state_->mutex);
  auto text = lines(state_->dropped);
  if (text.empty() && !state_->lines.empty()) return;
  if (!state_->lines.empty() && state_->waiting + text.size() > kMaxWaitingBytes) {
    ++state_->dropped;
    return;
  }
  state_->dropped = 0;
  state_->waiting += text.size();
  state_->lines.push_back(std::move(text));
  state_->write_or_wake_thread(lock);
}

void Outlet::draw(std::vector<std::string> picture) {
  std::unique_lock lock(state_->mutex);
  state_->picture = std::move(picture);
  state_->write_or_wake_thread(lock);
}

bool Outlet::has_failed() const {
  const std::lock_guard lock(state_->mutex);
  return state_->write_failed;
}

bool Outlet::flush() {
  std::unique_lock lock(state_->mutex);
  return state_->progress.wait_for(lock, kFlushTimeout, [this] { return state_->is_idle(); });
}

/// Detaches the thread if it has not finished within one second.
Outlet::~Outlet() {
  if (!writer_.joinable()) return;
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
    state_->available.notify_one();
  }
  if (flush())
    writer_.join();
  else
    writer_.detach();
}

std::string Screen::erase() {
  const auto open = std::exchange(lines_open_, 0);
  if (open == 0) return {};
  return (open > 1 ? fmt::format("\033[{}A", open - 1) : std::string()) + "\r\033[J";
}

std::string Screen::message(std::string_view text) { return erase() + std::string(text); }

std::string Screen::picture(const std::vector<std::string>& lines) {
  auto text = erase() + fmt::format("{}", fmt::join(lines, "\n"));
  lines_open_ = lines.size();
  return text;
}

std::string truncate_line(const std::string& line, std::size_t width) {
  std::size_t characters = 0;
  for (std::size_t i = 0; i < line.size(); ++i)
    if ((static_cast<unsigned char>(line[i]) & 0xC0) != 0x80 && characters++ == width) return line.substr(0, i);
  return line;
}

namespace {

std::size_t count_characters(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

void wrap_line(std::string_view line, std::size_t width, std::string& wrapped) {
  constexpr std::size_t kMoreIndent = 2;
  if (count_characters(line) <= width) return void(wrapped += line);
  const auto indent = std::min(line.find_first_not_of(' '), line.size());
  std::size_t used = 0;
  bool is_first = true;
  for (std::size_t at = 0; at < line.size();) {
    const auto word = std::min(line.find_first_not_of(' ', at), line.size());
    const auto end = std::min(line.find(' ', word), line.size());
    const auto blanks = word - at, length = count_characters(line.substr(word, end - word));
    if (length == 0) break;
    if (!is_first && used + blanks + length > width) {
      wrapped += '\n' + std::string(indent + kMoreIndent, ' ');
      used = indent + kMoreIndent;
    } else {
      wrapped.append(blanks, ' ');
      used += blanks;
    }
    wrapped += line.substr(word, end - word);
    used += length;
    is_first = false;
    at = end;
  }
}

}  // namespace

std::string wrap_lines(std::string_view text, std::size_t width) {
  std::string wrapped;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    wrap_line(text.substr(at, end - at), width, wrapped);
    if (end < text.size()) wrapped += '\n';
    at = end + 1;
  }
  return wrapped;
}

}  // namespace gyrotherm::app
