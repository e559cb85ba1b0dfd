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
constexpr std::int64_t kSamePressNs = 500'000'000;

std::atomic<int> stop_count{0};
std::atomic<int> termination_count{0};
std::atomic<int> hangup_count{0};
std::atomic<int> forgiven_hangup_count{0};
std::atomic<std::int64_t> first_signal_ns{0};  ///< ns of the monotonic clock
std::atomic<bool> second_signal_ends_program{false};
int wake_pipe[2] = {-1, -1};

std::int64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void on_signal(int number) {
  const int before = errno;
  ++(number == SIGHUP ? hangup_count : stop_count);
  if (number == SIGTERM) ++termination_count;
  if (interrupts() == 1) {
    first_signal_ns = now_ns();
  } else if (second_signal_ends_program && now_ns() - first_signal_ns > kSamePressNs) {
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
  second_signal_ends_program = second == SecondInterrupt::ends;
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

int interrupts() { return stop_count + hangup_count - forgiven_hangup_count; }

int stops() { return stop_count; }

int count_terminations() { return termination_count; }

int count_hangups() { return hangup_count; }

void discard_hangups() { forgiven_hangup_count = hangup_count.load(); }

int interrupt_descriptor() { return wake_pipe[0]; }

void drain_wake_ups() {
  char bytes[64];
  while (::read(wake_pipe[0], bytes, sizeof bytes) > 0) {
  }
}

}  // namespace gyrotherm::app
