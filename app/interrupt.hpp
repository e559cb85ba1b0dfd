/// Ctrl-C, SIGTERM and a lost terminal (SIGHUP) ask for a clean stop; nothing is done in the signal handler itself.
#pragma once

namespace gyrotherm {

/// Takes SIGINT, SIGTERM and SIGHUP over, and ignores SIGPIPE. Once, at the start of the program.
void watch_for_interrupts();

/// True from the first such signal on.
[[nodiscard]] bool interrupted();

/// How many there have been.
[[nodiscard]] int interrupts();

/// Becomes readable at each such signal; for an event loop.
[[nodiscard]] int interrupt_descriptor();
/// Makes it wait for the next one.
void take_wake_ups();

}  // namespace gyrotherm
