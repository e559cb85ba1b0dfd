// SPDX-License-Identifier: Apache-2.0
/// gyrotherm-make-safe: sends a chamber to its safe set point when the program that drives it has died or hangs. It
/// uses only the safe-state file, a connection to the chamber, and a trace next to the record: no event loop, no
/// database.
///
/// It acts first and reports afterwards. Operations that may hang (on a line, a disk or a terminal without a reader)
/// run in separate processes, so they do not delay the others.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/program_start.hpp"
#include "core/text.hpp"
#include "sequencer/watchdog/child_work.hpp"
#include "sequencer/watchdog/guard.hpp"
#include "sequencer/watchdog/relay_rescue.hpp"
#include "sequencer/watchdog/safe_attempt.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"
#include "sequencer/watchdog/trail.hpp"

namespace gyrotherm::watchdog {
namespace {

enum class MakeSafeExit : int {
  /// The chamber has confirmed the safe state, or no action was necessary.
  safe = 0,
  /// The command line is wrong.
  usage = 2,
  /// The chamber did not confirm the safe state, or was not reachable.
  not_confirmed = 3,
  /// The safe-state file is invalid, or the record does not exist.
  file = 4,
  /// A live program drives the chamber.
  in_use = 5,
};

using std::chrono::seconds;

constexpr auto kReceiveTimeout = seconds(10);
constexpr auto kKillTimeout = seconds(2);
/// Longest wait until the files next to the record are written.
constexpr auto kFileTimeout = seconds(5);
constexpr auto kRetryPause = seconds(1);
/// Longest observation of the air under a service manager. The manager restarts the run only after the observation, and
/// a run that was down for more than two minutes is not resumed automatically. The restarted program continues the
/// observation.
constexpr auto kMaxServiceObservation = seconds(60);
/// Longest wait, without --insist, for another program that drives the chamber, usually the run's guard.
constexpr int kInUseWaitSeconds = 15;

/// Longest wait until a guard carries out the order to give up: one attempt, with the steps after the set point.
constexpr auto kGiveUpTimeout = seconds(45);
/// Name of this program in a trace that no guard left.
constexpr const char* kByHand = "gyrotherm-make-safe";

constexpr const char* kHelp =
    "Example: gyrotherm-make-safe run.db\n\n"
    "Makes the chamber safe after the program of a run has died. Does nothing if the run ended normally.\n\n"
    "  gyrotherm-make-safe RUN.db          sends the set point (at most 10 s) and the mode (at most 25 s), then\n"
    "                                      watches the air for the time of [safe] observe; ends if the chamber\n"
    "                                      does not answer\n"
    "  gyrotherm-make-safe --kill RUN.db   first ends the program that drives the chamber, if it is still running\n"
    "  gyrotherm-make-safe --insist RUN.db as --kill, and repeats until the chamber confirms the safe state; for a\n"
    "                                      service manager\n"
    "  gyrotherm-make-safe --guard RUN.db  started by a run: monitors it through standard input; acts at end of file\n"
    "                                      or after 8 s without a byte, as --insist\n"
    "  gyrotherm-make-safe --give-up RUN.db REASON\n"
    "                                      ends the guard of a run whose program has died, although the chamber is "
    "NOT\n"
    "                                      confirmed safe; for a chamber that a person has made safe by hand\n"
    "  gyrotherm-make-safe --version       prints its version\n\n"
    "If the rig file has [safe.also], its relay is opened when the chamber cannot be made safe in time. It stays open\n"
    "until \"gyrotherm prove RIG --close-relay\".\n\n"
    "Exit codes: 0 safe, or nothing to do; 2 command line; 3 not confirmed by the chamber; 4 safe-state file is "
    "invalid,\n"
    "or no such record; 5 a running program drives the chamber.\n";

MakeSafeExit report_fault(ErrorPrinter& printer, const Fault& fault, MakeSafeExit exit) {
  printer.print(text(fault));
  return exit;
}

MakeSafeExit exit_code(const RescueResult& result) {
  if (result.reached == SafeStage::all) return MakeSafeExit::safe;
  return result.in_use ? MakeSafeExit::in_use : MakeSafeExit::not_confirmed;
}

/// Escalation that the command line selects.
enum class RescueMode { gentle, kill, insist };

/// The process that acts: the guard of a run, or the command of an operator or a service manager.
enum class Rescuer { guard, command };

MakeSafeExit make_safe_insistently(ErrorPrinter& printer, const SafeState& safe_state, const SafeStateChamber& chamber,
                                   const char* reason, Rescuer by);

SafeStateChamber limit_observation(SafeStateChamber chamber) {
  chamber.goal.observe = std::min<Duration>(chamber.goal.observe, kMaxServiceObservation);
  return chamber;
}

/// Opens the relay if it is due, and notes its state.
void advance_relay(RelayRescue& relay, RelayDue due, TraceWriter& trail, ErrorPrinter& printer) {
  const auto changed = relay.advance(due);
  if (!changed) return;
  printer.print(*changed);
  trail.note_relay(*changed);
}

std::string describe_unwritten(const TraceWriter& trail) {
  const auto& fault = trail.write_fault();
  return "no file could be written next to the record: " + (fault.empty() ? "the disk does not respond" : fault);
}

/// Waits until the trace is written. The guard may wait long, because no process waits for the guard.
void wait_for_disk(TraceWriter& trail, Rescuer by, ErrorPrinter& printer) {
  if (trail.settle(kFileTimeout)) return;
  const Duration longest = by == Rescuer::guard ? kMissingTimeLimit : Duration(kMaxServiceObservation);
  printer.print(describe_unwritten(trail) + fmt::format("; trying again for {} at most", format_duration(longest)));
  if (!trail.settle(longest)) printer.print(describe_unwritten(trail));
}

/// Returns whether a later run has taken the chamber over, and notes it.
bool is_relieved(const RescueResult& result, TraceWriter& trail, ErrorPrinter& printer) {
  if (result.successor.empty()) return false;
  printer.print(
      fmt::format("{} has taken the chamber over and has a guard of its own; nothing more is sent", result.successor));
  trail.hand_over_to(result.successor);
  return true;
}

/// Repeats attempts until the chamber is safe, another program drives it, or further attempts are useless. In the last
/// case the relay is opened.
RescueResult retry_until_safe(SafeRescue& rescue, RescueResult result, RelayRescue& relay, TraceWriter& trail,
                              ErrorPrinter& printer) {
  while (result.reached != SafeStage::all && !result.in_use && !rescue.is_exhausted() && !rescue.is_lost()) {
    if (trail.record(result)) printer.print(trail.describe());
    advance_relay(relay, is_relay_due(result), trail, printer);
    std::this_thread::sleep_for(rescue.pause());
    result = rescue.attempt(relay.left());
  }
  if (result.reached != SafeStage::all && !result.in_use) advance_relay(relay, RelayDue::now, trail, printer);
  return result;
}

bool has_safe_state(const std::string& record) {
  std::error_code error;
  return std::filesystem::exists(safe_state_path(record), error);
}

/// Returns the record of a run in progress to which a file belongs by its name, such as RUN.db for RUN.live.db and
/// RUN.db.status. Returns the path itself if there is none.
std::string find_record(const std::string& path) {
  constexpr std::string_view kEnding = ".db", kLive = ".live";
  if (has_safe_state(path)) return path;
  for (auto at = path.find(kEnding, path.rfind('/') + 1); at != std::string::npos; at = path.find(kEnding, at + 1)) {
    auto stem = path.substr(0, at);
    if (stem.ends_with(kLive)) stem.resize(stem.size() - kLive.size());
    for (const auto& record : {stem + std::string(kEnding), stem})
      if (has_safe_state(record)) return record;
  }
  return path;
}

/// Returns whether a path without a safe-state file is a record. Reports the reason if it is not.
bool check_is_record(ErrorPrinter& printer, const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    printer.print(path + ": the record does not exist and has no safe-state file; check the path");
    return false;
  }
  if (!begins_with(path, kSqliteBeginning).value_or(false)) {
    printer.print(path + ": is not a record, expected the record of the run, RUN.db");
    return false;
  }
  return true;
}

/// Prints that no run is in progress, and returns `safe`. If the path is not a record, prints the reason and returns
/// `file`.
MakeSafeExit report_no_run(ErrorPrinter& printer, const std::string& path) {
  if (!check_is_record(printer, path)) return MakeSafeExit::file;
  printer.print(path + ": no run is in progress; nothing to do");
  return MakeSafeExit::safe;
}

/// Returns the exit code for a record whose safe-state file was removed after `since`, UTC. Only a newer trace shows
/// that the chamber is safe.
MakeSafeExit judge_removal(ErrorPrinter& printer, const std::string& record, Duration since) {
  const auto trace = read_trace(record);
  const bool is_newer = trace && *trace && (*trace)->at >= since;
  if (is_newer && is_taken_over(**trace)) {
    printer.print(record + ": a later run has taken its chamber over");
    return MakeSafeExit::in_use;
  }
  if (is_newer && (*trace)->confirmed) {
    printer.print(record + ": another program has made its chamber safe");
    return MakeSafeExit::safe;
  }
  printer.print(record + ": its safe-state file was removed, but nothing shows that the chamber is safe; check it");
  return MakeSafeExit::not_confirmed;
}

MakeSafeExit make_safe(ErrorPrinter& printer, const std::string& path, RescueMode mode) {
  const auto began = SteadyClock().now().utc;
  const auto record = find_record(path);
  if (record != path) printer.print(fmt::format("{} belongs to {}", path, record));
  auto safe_state = read_safe_state(safe_state_path(record));
  if (!safe_state) return report_fault(printer, safe_state.error(), MakeSafeExit::file);
  if (!*safe_state) return report_no_run(printer, record);
  if ((*safe_state)->record != record) {
    printer.print(fmt::format("the safe-state file is for {}; using it for {}", (*safe_state)->record, record));
    (*safe_state)->record = record;
  }
  const auto& by = (*safe_state)->written_by;
  if (mode == RescueMode::gentle && is_alive(by)) {
    printer.print(fmt::format("process {} is running and drives the chamber; use --kill to end it first", by.pid));
    return MakeSafeExit::in_use;
  }
  const auto chamber = make_safe_state_chamber(**safe_state);
  if (!chamber) return report_fault(printer, chamber.error(), MakeSafeExit::file);
  constexpr const char* kReason = "the program that drove it had ended";
  if (mode == RescueMode::insist)
    return make_safe_insistently(printer, **safe_state, limit_observation(*chamber), kReason, Rescuer::command);
  if (!kill_process(by, kKillTimeout)) printer.print(fmt::format("cannot end process {}", by.pid));
  TraceWriter trail(**safe_state, kReason, kByHand);
  SafeRescue rescue(**safe_state, *chamber, printer);
  RelayRescue relay((*safe_state)->also);
  auto result = rescue.attempt(relay.left());
  for (int waited = 0; result.in_use && result.successor.empty() && waited < kInUseWaitSeconds; ++waited) {
    std::this_thread::sleep_for(seconds(1));
    if (const auto now = read_safe_state(safe_state_path(record)); now && !*now)
      return judge_removal(printer, record, began);
    result = rescue.attempt();
  }
  result = retry_until_safe(rescue, std::move(result), relay, trail, printer);
  if (is_relieved(result, trail, printer)) (void)trail.settle(kFileTimeout);
  if (result.in_use) return exit_code(result);
  trail.record(result);
  if (result.reached == SafeStage::all) trail.remove_safe_state();
  printer.print(trail.describe());
  if (!trail.settle(kFileTimeout)) printer.print(describe_unwritten(trail));
  return exit_code(result);
}

const char* describe(WatchEnd end) {
  return end == WatchEnd::silent ? "the program that drove it hung"
                                 : "the program that drove it ended before the chamber was safe";
}

/// Repeats attempts until the chamber has confirmed the safe state, or until another program has taken over the run or
/// the chamber, or has made the chamber safe. A program that merely holds the chamber's lock is no reason to end: it
/// may leave the chamber as it is.
MakeSafeExit make_safe_insistently(ErrorPrinter& printer, const SafeState& safe_state, const SafeStateChamber& chamber,
                                   const char* reason, Rescuer by) {
  SafeRescue rescue(safe_state, chamber, printer);
  if (!kill_process(safe_state.written_by, kKillTimeout))
    printer.print(fmt::format("cannot end process {}", safe_state.written_by.pid));
  TraceWriter trail(safe_state, reason, by == Rescuer::guard ? "" : kByHand);
  RelayRescue relay(safe_state.also);
  auto result = rescue.attempt(relay.left());
  printer.print(reason);
  for (;; result = rescue.attempt(relay.left())) {
    if (!result.in_use && trail.record(result)) printer.print(trail.describe());
    if (!result.in_use) advance_relay(relay, is_relay_due(result), trail, printer);
    if (result.reached == SafeStage::all) break;
    if (is_relieved(result, trail, printer)) break;
    if (const auto why = trail.find_end_reason()) {
      printer.print(*why + "; giving up");
      if (!trail.give_up_order().empty()) trail.note_given_up(trail.give_up_order());
      break;
    }
    std::this_thread::sleep_for(result.in_use ? Duration(kRetryPause) : rescue.pause());
  }
  if (result.reached == SafeStage::all) trail.remove_safe_state();
  wait_for_disk(trail, by, printer);
  return trail.is_fulfilled() ? MakeSafeExit::safe : exit_code(result);
}

/// Returns the safe state that the starting program sends. If that program died before it sent the safe state, returns
/// the one in the safe-state file.
Result<SafeState> obtain_safe_state(const std::string& record) {
  const auto file = safe_state_path(record);
  const auto orders = receive_safe_state(STDIN_FILENO, kReceiveTimeout);
  if (orders) return parse_safe_state(*orders, file);
  const auto left = read_safe_state(file);
  if (left && *left && wait_for_end((*left)->written_by, kKillTimeout)) return **left;
  return failure(orders.error());
}

MakeSafeExit guard(ErrorPrinter& printer, const std::string& record) {
  const auto safe_state = obtain_safe_state(record);
  if (!safe_state)
    return report_fault(printer, safe_state.error(),
                        safe_state.error().kind == FaultKind::bad_file ? MakeSafeExit::file : MakeSafeExit::usage);
  const auto chamber = make_safe_state_chamber(*safe_state);
  if (!chamber) return report_fault(printer, chamber.error(), MakeSafeExit::file);
  // A failure is ignored: if the program has ended, watch() detects the end of file.
  [[maybe_unused]] const auto sent = ::write(STDIN_FILENO, &kWatching, 1);
  const auto end = watch(STDIN_FILENO);
  if (end == WatchEnd::good_bye) return MakeSafeExit::safe;
  const bool is_service = std::getenv("NOTIFY_SOCKET") != nullptr;
  for (;; std::this_thread::sleep_for(kRetryPause)) try {
      return make_safe_insistently(printer, *safe_state, is_service ? limit_observation(*chamber) : *chamber,
                                   describe(end), Rescuer::guard);
      // An exception in a library must not leave the chamber unsafe.
    } catch (const std::exception& failed) {
      printer.print(fmt::format("{}; retrying", failed.what()));
    }
}

/// Returns true if the chamber was confirmed safe, and the guard needs no order any more.
bool has_guard_finished(const std::string& record) {
  const auto trace = read_trace(record);
  return !has_safe_state(record) && trace && *trace && (*trace)->confirmed;
}

/// Waits at most kGiveUpTimeout until the guard has carried out the order to give up, or has made the chamber safe
/// without it; in the second case removes the order. Returns false if neither happens.
bool wait_for_guard(const std::string& record) {
  for (const Deadline limit(kGiveUpTimeout); !limit.has_passed();
       std::this_thread::sleep_for(std::chrono::milliseconds(200))) {
    if (read_give_up(record).empty()) return true;
    if (!has_guard_finished(record)) continue;
    remove_give_up(record);
    return true;
  }
  return false;
}

/// Orders the guard of a run to give up. Without a guard, leaves the trace itself. Commands no chamber. Returns `safe`
/// if the guard confirms the chamber meanwhile, and `in_use` if a later run takes the chamber over.
MakeSafeExit give_up(ErrorPrinter& printer, const std::string& path, const std::string& reason) {
  const auto record = find_record(path);
  const auto safe_state = read_safe_state(safe_state_path(record));
  if (!safe_state) return report_fault(printer, safe_state.error(), MakeSafeExit::file);
  if (!*safe_state) {
    if (!check_is_record(printer, record)) return MakeSafeExit::file;
    printer.print(record + ": no guard is at work; nothing to give up");
    return MakeSafeExit::safe;
  }
  if (is_alive((*safe_state)->written_by)) {
    printer.print(fmt::format("process {} is running and drives the chamber; stop the run instead",
                              (*safe_state)->written_by.pid));
    return MakeSafeExit::in_use;
  }
  const auto order = fmt::format("{}: {}", describe_user(::geteuid()), reason);
  if (auto written = write_give_up(record, order); !written)
    return report_fault(printer, written.error(), MakeSafeExit::file);
  printer.print(fmt::format("the guard ends after its present attempt, within {} s", kGiveUpTimeout.count()));
  if (!wait_for_guard(record)) {
    printer.print("no guard answers; its files are removed");
    TraceWriter trail(**safe_state, "the program that drove it had ended", kByHand);
    trail.note_given_up(order);
    if (!trail.settle(kFileTimeout)) printer.print(describe_unwritten(trail));
  }
  const auto trace = read_trace(record);
  const bool has_trace = trace && *trace;
  if (has_trace) printer.print(describe(**trace));
  // The guard may have finished before it read the order.
  if (has_trace && (*trace)->given_up.empty() && (*trace)->confirmed) return MakeSafeExit::safe;
  if (has_trace && is_taken_over(**trace)) return MakeSafeExit::in_use;
  printer.print("the chamber is NOT confirmed safe and nothing guards it: check it yourself");
  return MakeSafeExit::not_confirmed;
}

/// Ignores signals that must not stop the rescue. A closing terminal, Ctrl-C, the end of a session, or a service
/// watchdog sends them.
void ignore_signals() {
  for (const int number : {SIGINT, SIGHUP, SIGTERM, SIGQUIT, SIGABRT, SIGTSTP, SIGTTOU, SIGTTIN})
    std::signal(number, SIG_IGN);
  // The kernel then reaps child processes that end after a hang.
  std::signal(SIGCHLD, SIG_IGN);
}

/// Resolves a symbolic link to a record, because the safe-state file is next to the record itself.
std::string resolve_symlink(const std::string& record) {
  std::error_code error;
  if (!is_symlink(std::filesystem::symlink_status(record, error))) return record;
  const auto target = std::filesystem::canonical(record, error);
  return error ? record : target.string();
}

MakeSafeExit run(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "--help" || first == "-h")
    return std::fputs(kHelp, stdout) < 0 ? MakeSafeExit::usage : MakeSafeExit::safe;
  if (first == "--version")
    return std::puts("gyrotherm-make-safe " GYROTHERM_VERSION) < 0 ? MakeSafeExit::usage : MakeSafeExit::safe;
  std::signal(SIGPIPE, SIG_IGN);
  if (first == "--guard") {
    // Closes the inherited locks and connections of the watched program.
    ::close_range(STDERR_FILENO + 1, ~0U, 0);
    ignore_signals();
  }
  ErrorPrinter printer;
  std::error_code error;
  if (first == "--give-up" && argc == 4 && *argv[3] != '\0')
    return give_up(printer, resolve_symlink(std::filesystem::absolute(argv[2], error).string()), argv[3]);
  const bool with_option = first == "--guard" || first == "--kill" || first == "--insist";
  if (first.starts_with('-') && !with_option && first != "--give-up") {
    const std::array<std::string, 6> options{"--kill", "--insist", "--guard", "--give-up", "--help", "--version"};
    const auto near = find_nearest(first, options);
    printer.print(
        fmt::format("{} is not an option{}", first, near.empty() ? "" : fmt::format("; did you mean {}?", near)));
  }
  if (argc != (with_option ? 3 : 2) || (!with_option && first.starts_with('-')) || *argv[argc - 1] == '\0') {
    printer.print("expected [--kill|--insist|--guard] RUN.db, or --give-up RUN.db REASON; see --help");
    return MakeSafeExit::usage;
  }
  const auto record = std::filesystem::absolute(argv[argc - 1], error).string();
  if (first == "--guard") return guard(printer, record);
  const auto mode = first == "--insist" ? RescueMode::insist
                    : first == "--kill" ? RescueMode::kill
                                        : RescueMode::gentle;
  return make_safe(printer, resolve_symlink(record), mode);
}

}  // namespace
}  // namespace gyrotherm::watchdog

int main(int argc, char** argv) {
  gyrotherm::open_standard_descriptors();
  return static_cast<int>(gyrotherm::watchdog::run(argc, argv));
}
