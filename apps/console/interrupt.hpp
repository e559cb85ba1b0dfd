// SPDX-License-Identifier: Apache-2.0
/// Handling of Ctrl-C, SIGTERM and a lost terminal (SIGHUP). By default they end the program at once. A command that
/// must stop in order calls watch_for_interrupts() and polls; the signal handler itself only counts.
#pragma once

namespace gyrotherm::app {

/// Effect of a second signal that arrives more than half a second after the first.
enum class SecondInterrupt {
  ends,        ///< ends the program at once
  is_counted,  ///< only counts; the command decides
};

/// Catches SIGINT, SIGTERM and SIGHUP from now on. A SIGHUP that was ignored at the start of the program (nohup)
/// remains ignored. Call it where polling of interrupted() begins. A further call changes `second` only.
void watch_for_interrupts(SecondInterrupt second);

/// Ignores SIGPIPE and SIGXFSZ, so that a closed reader or a file size limit makes the write fail instead of ending the
/// program. Call it once, at the start of the program.
void ignore_write_signals();

/// Returns whether a signal has arrived. Forgiven hang-ups do not count.
[[nodiscard]] bool interrupted();

/// Counts all signals except forgiven hang-ups.
[[nodiscard]] int interrupts();
/// Count the requests to stop (SIGINT, SIGTERM) and the losses of the terminal (SIGHUP).
[[nodiscard]] int stops();
/// Counts SIGTERM alone: a shutdown, a service manager or the end of a session.
[[nodiscard]] int terminations();
[[nodiscard]] int hangups();
/// Marks all hang-ups so far as handled; interrupts() no longer counts them.
void forgive_hangups();

/// Returns a descriptor that becomes readable at each signal, for an event loop; −1 before watch_for_interrupts().
[[nodiscard]] int interrupt_descriptor();
/// Reads the descriptor empty, so that it waits for the next signal.
void drain_wake_ups();

}  // namespace gyrotherm::app
