// SPDX-License-Identifier: Apache-2.0
#include "apps/console/interrupt.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <ctime>

namespace gyrotherm::app {
namespace {

/// Signals within this time after the first one belong to the same key press, ns.
constexpr std::int64_t kOnePress = 500'000'000;

std::atomic<int> stops_so_far{0};
std::atomic<int> terminations_so_far{0};
std::atomic<int> hangups_so_far{0};
std::atomic<int> hangups_forgiven{0};
std::atomic<std::int64_t> first_at{0};  ///< ns of the monotonic clock
std::atomic<bool> second_ends{false};
int wake_pipe[2] = {-1, -1};

std::int64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void on_signal(int number) {
  const int before = errno;
  ++(number == SIGHUP ? hangups_so_far : stops_so_far);
  if (number == SIGTERM) ++terminations_so_far;
  if (interrupts() == 1) {
    first_at = now_ns();
  } else if (second_ends && now_ns() - first_at > kOnePress) {
    std::signal(number, SIG_DFL);
    std::raise(number);  // delivered when this handler returns
  }
  [[maybe_unused]] const auto written = ::write(wake_pipe[1], "", 1);
  errno = before;
}

bool is_ignored(int number) {
  struct sigaction now {};
  return ::sigaction(number, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

}  // namespace

void watch_for_interrupts(SecondInterrupt second) {
  second_ends = second == SecondInterrupt::ends;
  if (wake_pipe[0] >= 0) return;
  if (::pipe2(wake_pipe, O_CLOEXEC | O_NONBLOCK) != 0) wake_pipe[0] = wake_pipe[1] = -1;
  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  if (!is_ignored(SIGHUP)) ::sigaction(SIGHUP, &action, nullptr);
}

void ignore_write_signals() {
  for (const int number : {SIGPIPE, SIGXFSZ}) std::signal(number, SIG_IGN);
}

bool interrupted() { return interrupts() > 0; }

int interrupts() { return stops_so_far + hangups_so_far - hangups_forgiven; }

int stops() { return stops_so_far; }

int terminations() { return terminations_so_far; }

int hangups() { return hangups_so_far; }

void forgive_hangups() { hangups_forgiven = hangups_so_far.load(); }

int interrupt_descriptor() { return wake_pipe[0]; }

void drain_wake_ups() {
  char bytes[64];
  while (::read(wake_pipe[0], bytes, sizeof bytes) > 0) {
  }
}

}  // namespace gyrotherm::app
