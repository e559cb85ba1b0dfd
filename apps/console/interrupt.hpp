// SPDX-License-Identifier: Apache-2.0
/// Handles Ctrl-C, SIGTERM and a lost terminal (SIGHUP). By default these signals end the program immediately. A
/// command that must finish cleanly calls watch_for_interrupts() and polls; the signal handler itself only counts
/// signals.
#pragma once

namespace gyrotherm::app {

/// Effect of a second signal that arrives more than half a second after the first.
enum class SecondInterrupt {
  ends,        ///< ends the program immediately
  is_counted,  ///< only increments the counter
};

/// Catches SIGINT, SIGTERM and SIGHUP from now on. A SIGHUP that was ignored at the start of the program (nohup)
/// remains ignored. Call it before you first poll interrupted(). A further call changes only `second`.
void watch_for_interrupts(SecondInterrupt second);

/// Ignores SIGPIPE and SIGXFSZ. A write to a closed pipe or beyond a file size limit then fails and does not end the
/// program. Call it once, at the start of the program.
void ignore_write_signals();

/// Returns true if interrupts() is above 0.
[[nodiscard]] bool interrupted();

/// Returns the number of signals so far, except hang-ups discarded by discard_hangups().
[[nodiscard]] int interrupts();
/// Returns the number of requests to stop so far: SIGINT and SIGTERM.
[[nodiscard]] int stops();
/// Returns the number of SIGTERM signals so far. A shutdown, a service manager or the end of a session sends SIGTERM.
[[nodiscard]] int count_terminations();
/// Returns the number of hang-ups (SIGHUP: loss of the terminal) so far, including discarded ones.
[[nodiscard]] int count_hangups();
/// Discards all hang-ups so far: interrupts() no longer counts them.
void discard_hangups();

/// Returns a descriptor that becomes readable at each signal, for an event loop; −1 before watch_for_interrupts().
[[nodiscard]] int interrupt_descriptor();
/// Discards all bytes in the descriptor. It becomes readable again at the next signal.
void drain_wake_ups();

}  // namespace gyrotherm::app
