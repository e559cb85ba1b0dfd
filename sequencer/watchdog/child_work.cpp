// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/child_work.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>

#include "core/deadline.hpp"
#include "core/text.hpp"

namespace gyrotherm::watchdog {

ChildWork::ChildWork(const std::function<void(const SendLine&)>& work)
    : child_([&](int to_parent) { work([&](const std::string& line) { (void)write_all(to_parent, line + "\n"); }); }) {
  ended_ = !child_.has_begun();
}

std::optional<std::string> ChildWork::take_line() {
  const auto end = received_.find('\n');
  if (end == std::string::npos) return {};
  auto line = received_.substr(0, end);
  received_.erase(0, end + 1);
  return line;
}

std::optional<std::string> ChildWork::next(Duration within) {
  const Deadline deadline(within);
  for (;;) {
    if (auto line = take_line()) return line;
    if (ended_ || !wait_until_ready(child_.output(), POLLIN, deadline)) return {};
    std::array<char, 4096> piece;
    const auto size = read_some(child_.output(), piece.data(), piece.size());
    if (size <= 0) ended_ = true;
    if (size > 0) received_.append(piece.data(), static_cast<std::size_t>(size));
  }
}

ErrorPrinter::ErrorPrinter() {
  auto pipe = new_pipe();
  pid_ = pipe.from.is_open() ? ::fork() : -1;
  if (pid_ == 0) {
    pipe.to.close();
    detach_standard_input();
    std::array<char, 4096> piece;
    for (ssize_t size; (size = read_some(pipe.from.number(), piece.data(), piece.size())) > 0;)
      (void)write_all(STDERR_FILENO, {piece.data(), static_cast<std::size_t>(size)});
    ::_exit(0);
  }
  pipe_ = std::move(pipe.to);
  if (pipe_.is_open()) ::fcntl(pipe_.number(), F_SETFL, O_NONBLOCK);
}

ErrorPrinter::~ErrorPrinter() {
  pipe_.close();
  if (pid_ > 0) [[maybe_unused]]
    const bool ended = reap(pid_, std::chrono::seconds(1));
}

void ErrorPrinter::print(const std::string& line) {
  const auto whole = "gyrotherm-make-safe: " + plain(line, Blanks::kept) + "\n";
  if (pipe_.is_open()) [[maybe_unused]]
    const auto written = ::write(pipe_.number(), whole.data(), whole.size());
}

}  // namespace gyrotherm::watchdog
