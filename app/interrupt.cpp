#include "app/interrupt.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <csignal>

namespace gyrotherm {
namespace {

std::atomic<int> interrupts_so_far{0};
int wake_pipe[2] = {-1, -1};

void on_signal(int) {
  ++interrupts_so_far;
  [[maybe_unused]] const auto written = ::write(wake_pipe[1], "", 1);
}

}  // namespace

void watch_for_interrupts() {
  if (::pipe2(wake_pipe, O_CLOEXEC | O_NONBLOCK) != 0) wake_pipe[0] = wake_pipe[1] = -1;
  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGHUP, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return interrupts_so_far > 0; }

int interrupts() { return interrupts_so_far; }

int interrupt_descriptor() { return wake_pipe[0]; }

void take_wake_ups() {
  char bytes[64];
  while (::read(wake_pipe[0], bytes, sizeof bytes) > 0) {
  }
}

}  // namespace gyrotherm
