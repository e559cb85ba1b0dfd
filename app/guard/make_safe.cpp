/// gyrotherm-make-safe: sends a chamber to its safe set point when the program that drives it has died or hangs. No
/// event loop, no database, no Qt: the armed file, one connection to the chamber, a trace beside the record.
#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>

#include "app/guard/armed_file.hpp"
#include "app/guard/guard.hpp"
#include "app/guard/made_safe_file.hpp"
#include "app/guard/safe_attempt.hpp"
#include "drivers/chamber/chamber_lock.hpp"

namespace gyrotherm {
namespace {

enum class MakeSafeExit : int {
  safe = 0,           ///< confirmed, or there was nothing to do
  usage = 2,          ///< the command line is wrong
  not_confirmed = 3,  ///< the chamber did not take it, or could not be reached
  file = 4,           ///< the armed file is wrong
  in_use = 5,         ///< a program that lives drives the chamber
};

constexpr auto kBetweenAttempts = std::chrono::seconds(10);
constexpr int kGivesUpTo = 60;  ///< s for which another program has had the chamber

constexpr const char* kHelp =
    "Example: gyrotherm-make-safe run.db\n\n"
    "Makes the chamber of a run safe whose program has died. Does nothing if the run had ended in order.\n\n"
    "  gyrotherm-make-safe RUN.db          once: at most 3 tries, at most 10 s\n"
    "  gyrotherm-make-safe --kill RUN.db   ends the program that drives the chamber first, if it still lives\n"
    "  gyrotherm-make-safe --guard RUN.db  watches standard input: acts at its end or after 8 s without a byte\n\n"
    "Exit codes: 0 safe, or nothing to do; 2 command line; 3 not confirmed by the chamber; 4 armed file is wrong;\n"
    "5 a program that lives drives the chamber.\n";

void say(const std::string& line) {
  const auto whole = "gyrotherm-make-safe: " + line + "\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, whole.data(), whole.size());
}

MakeSafeExit complain(const Fault& fault, MakeSafeExit exit) {
  say(text(fault));
  return exit;
}

/// The last resort against a call that hangs: the trace, written before, says that nothing was confirmed.
void end_in_time(int) {
  constexpr char kLine[] = "gyrotherm-make-safe: not confirmed within 10 s\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kLine, sizeof kLine - 1);
  ::_exit(static_cast<int>(MakeSafeExit::not_confirmed));
}

MadeSafe trace_of(const Armed& armed, const std::string& because) {
  return {.at = SteadyClock().now().utc,
          .because = because,
          .set_point = armed.safe_set_point,
          .confirmed = false,
          .details = "under way"};
}

void leave(const Armed& armed, const MadeSafe& trace) {
  if (const auto left = leave_trace(armed.record, trace); !left) say(text(left.error()));
}

/// One attempt with the chamber's lock held. What it says is in the trace and on standard error.
MakeSafeExit act(const Armed& armed, const std::string& because) {
  const auto chamber = chamber_of(armed);
  if (!chamber) return complain(chamber.error(), MakeSafeExit::file);
  const auto lock = ChamberLock::take(chamber->place, armed.record + " (made safe)");
  if (!lock && lock.error().kind == FaultKind::refused) return complain(lock.error(), MakeSafeExit::in_use);
  if (!lock) say(text(lock.error()));  // a chamber without a lock is made safe all the same
  auto trace = trace_of(armed, because);
  leave(armed, trace);
  ::alarm(static_cast<unsigned>(kSafeWithin / std::chrono::seconds(1)));
  const SteadyClock clock;
  const auto attempt = attempt_safe(
      chamber->goal,
      {.connect = chamber->connect, .wait = [](Duration time) { std::this_thread::sleep_for(time); }, .clock = clock});
  ::alarm(0);
  trace.confirmed = attempt.confirmed;
  trace.details = attempt.details;
  leave(armed, trace);
  say(in_words(trace));
  if (!attempt.confirmed) return MakeSafeExit::not_confirmed;
  disarm(armed.record);
  return MakeSafeExit::safe;
}

MakeSafeExit once(const std::string& record, bool kill) {
  const auto armed = read_armed(armed_path(record));
  if (!armed) return complain(armed.error(), MakeSafeExit::file);
  if (!*armed) {
    say(record + ": no run is under way; nothing to do");
    return MakeSafeExit::safe;
  }
  if (!kill && lives((*armed)->armed_by)) {
    say(fmt::format("process {} drives the chamber and lives; with --kill it is ended first", (*armed)->armed_by.pid));
    return MakeSafeExit::in_use;
  }
  if (!kill_surely((*armed)->armed_by, std::chrono::seconds(2)))
    say(fmt::format("process {} could not be ended", (*armed)->armed_by.pid));
  return act(**armed, "the program that drove it had ended");
}

/// Whether the run is still the one that was watched. A file that cannot be read counts as unchanged.
bool still_armed(const Armed& armed) {
  const auto now = read_armed(armed_path(armed.record));
  return !now || (*now && (*now)->armed_by == armed.armed_by);
}

const char* in_words(WatchEnd end) {
  return end == WatchEnd::silent ? "the program that drove it hung" : "the program that drove it ended without a word";
}

/// Until the chamber has confirmed it, or another program has taken the run or for a minute the chamber, or somebody
/// has removed the armed file.
MakeSafeExit guard(const std::string& record) {
  const auto armed = read_armed(armed_path(record));
  if (!armed) return complain(armed.error(), MakeSafeExit::file);
  if (!*armed) return complain({FaultKind::bad_file, armed_path(record), "is not there"}, MakeSafeExit::file);
  const auto end = watch(STDIN_FILENO);
  if (end == WatchEnd::good_bye) return MakeSafeExit::safe;
  const auto& watched = **armed;
  if (!still_armed(watched)) return MakeSafeExit::safe;
  say(in_words(end));
  if (!kill_surely(watched.armed_by, std::chrono::seconds(2)))
    say(fmt::format("process {} could not be ended", watched.armed_by.pid));
  auto outcome = MakeSafeExit::not_confirmed;
  for (int in_use = 0; still_armed(watched) && in_use < kGivesUpTo;) {
    outcome = act(watched, in_words(end));
    if (outcome == MakeSafeExit::safe || outcome == MakeSafeExit::file) break;
    in_use = outcome == MakeSafeExit::in_use ? in_use + 1 : 0;
    std::this_thread::sleep_for(in_use > 0 ? std::chrono::seconds(1) : kBetweenAttempts);
  }
  return outcome;
}

/// A terminal that closes, its Ctrl-C and an orderly end of the session are no reasons to leave a chamber alone.
void survive() {
  for (const int number : {SIGINT, SIGHUP, SIGTERM, SIGPIPE, SIGTSTP, SIGTTOU, SIGTTIN}) std::signal(number, SIG_IGN);
}

MakeSafeExit run(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "--help" || first == "-h")
    return std::fputs(kHelp, stdout) < 0 ? MakeSafeExit::usage : MakeSafeExit::safe;
  const bool with_option = first == "--guard" || first == "--kill";
  if (argc != (with_option ? 3 : 2) || (!with_option && first.starts_with('-'))) {
    say("expected [--guard|--kill] RUN.db; --help says more");
    return MakeSafeExit::usage;
  }
  std::signal(SIGALRM, end_in_time);
  std::signal(SIGPIPE, SIG_IGN);
  std::error_code error;
  const auto record = std::filesystem::absolute(argv[argc - 1], error).string();
  if (first != "--guard") return once(record, first == "--kill");
  ::close_range(STDERR_FILENO + 1, ~0U, 0);  // no lock and no line of the program that is watched
  survive();
  return guard(record);
}

}  // namespace
}  // namespace gyrotherm

int main(int argc, char** argv) { return static_cast<int>(gyrotherm::run(argc, argv)); }
