// SPDX-License-Identifier: Apache-2.0
/// Ctrl-C, SIGTERM and a lost terminal (SIGHUP) end the program at once, unless a command asks to be told of them, so
/// as to stop in order; nothing is done in the signal handler itself.
#pragma once

namespace gyrotherm::app {

/// What the second signal does where the first has not ended the program, and came half a second before or earlier.
enum class SecondInterrupt {
  ends,        ///< the program, at once
  is_counted,  ///< and no more: whoever drives a real chamber decides
};

/// Takes SIGINT, SIGTERM and SIGHUP over; a SIGHUP that was ignored when the program started (nohup) stays ignored. For
/// a command that looks at interrupted() again and again, from where it begins to. Again: `second` anew.
void watch_for_interrupts(SecondInterrupt second);

/// A reader that has gone, and a bound on the size of files, are found by the write that fails, not by SIGPIPE and
/// SIGXFSZ. Once, at the start of the program.
void let_writes_fail();

/// True from the first such signal on, forgiven ones aside.
[[nodiscard]] bool interrupted();

/// How many there have been, forgiven ones aside.
[[nodiscard]] int interrupts();
/// How many asked for an end (SIGINT, SIGTERM), and how many said that the terminal is lost (SIGHUP).
[[nodiscard]] int stops();
/// Counts the SIGTERM among them: a shutdown, a service manager, the end of a session.
[[nodiscard]] int terminations();
[[nodiscard]] int hangups();
/// The lost terminal has been answered, and is no interrupt any more.
void forgive_hangups();

/// Becomes readable at each such signal; for an event loop. None (−1) while nobody watches.
[[nodiscard]] int interrupt_descriptor();
/// Makes it wait for the next one.
void take_wake_ups();

}  // namespace gyrotherm::app
