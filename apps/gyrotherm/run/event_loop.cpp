// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <poll.h>

#include <QCoreApplication>
#include <QSocketNotifier>
#include <QTimer>
#include <array>
#include <chrono>
#include <optional>
#include <utility>

#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/run/carry_out.hpp"
#include "apps/gyrotherm/run/display.hpp"
#include "apps/gyrotherm/run/operator_mark.hpp"
#include "apps/gyrotherm/run/pace.hpp"
#include "apps/gyrotherm/run/run_decider.hpp"
#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "sequencer/control/control_socket.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono::steady_clock;

constexpr auto kLongestBatch = std::chrono::milliseconds(500);
/// Longest wait for the disk after a request to stop.
constexpr auto kLongestFlush = std::chrono::seconds(3);
/// Ticks between two readings of the wall clock.
constexpr int kTicksPerClockCheck = 64;

/// Returns the overview of the run, including a fault if rows are waiting for the disk.
RunOverview overview_with_disk_faults(const ActiveRun& run) {
  auto overview = run.run_controller.overview();
  if (auto health = run.store.health(); !health.trouble.empty())
    overview.faults_now.push_back(fmt::format("{} s are waiting for the disk: {}", health.backlog_s, health.trouble));
  return overview;
}

/// Adds the last second to the history of a run that ends by itself, and carries out a decision that is due.
Result<void> decide_if_due(const ActiveRun& run) {
  return run.decider ? run.decider->after_tick(run.run_controller, run.console) : Result<void>();
}

std::string goal_line(const ActiveRun& run) {
  return run.decider ? run.decider->describe_progress(run.run_controller.next_slot()) : std::string();
}

/// Opens the control socket. Prints a warning if that fails; the run then takes no requests.
std::optional<control::ControlSocket> open_control_socket(const ActiveRun& run) {
  auto socket = control::ControlSocket::open(run.path);
  if (socket) return std::move(*socket);
  run.console.print_message("warning: " + text(socket.error()));
  return {};
}

void handle_requests(const ActiveRun& run, std::optional<control::ControlSocket>& control_socket) {
  if (!control_socket) return;
  control_socket->listen([&](const control::ControlRequest& request, const std::string& client) {
    auto answer = run.run_controller.carry_out(request, client);
    run.console.print_message(
        fmt::format("{} by {}: {}", answer.done ? "request" : "refused request", client, answer.text));
    return answer;
  });
}

Result<void> sync(const ActiveRun& run) {
  run.store.publish(run.run_controller.overview());
  const auto last = run.store.sync();
  if (!last) return failure(last.error());
  if (!run.console.json || *last < 0) return {};
  run.console.print_fact([&](std::size_t missed) {
    return missed == 0 ? fmt::format("{{\"acknowledged\": {}}}\n", *last)
                       : fmt::format("{{\"acknowledged\": {}, \"missed\": {}}}\n", *last, missed);
  });
  return {};
}

Result<run::RunOutcome> finish_stopped(const ActiveRun& run) {
  if (auto noted = run.store.append_event({run.rig.clock().now(), EventKind::interrupted, "stopped by a signal"});
      !noted)
    return failure(noted.error());
  (void)await_end_on_disk(run);
  if (auto synced = sync(run); !synced) return failure(synced.error());
  return failure(FaultKind::interrupted, "", "stopped");
}

/// Appends the events of the run that no second has recorded yet.
Result<void> append_pending_events(const ActiveRun& run) {
  Result<void> done;
  for (const auto& event : run.run_controller.take_pending_events())
    if (done) done = run.store.append_event(event);
  return done;
}

/// Ends a run after SIGTERM, once the safe set point has been sent. Does not release the chamber, so the watchdog takes
/// over.
Result<run::RunOutcome> finish_terminated(const ActiveRun& run) {
  const auto now = run.rig.clock().now();
  if (auto noted = append_pending_events(run); !noted) return failure(noted.error());
  if (auto noted = run.store.append_event({now, EventKind::interrupted, run.run_controller.end_cause()}); !noted)
    return failure(noted.error());
  await_disk(run);
  if (auto synced = sync(run); !synced) return failure(synced.error());
  return failure(FaultKind::interrupted, "", "stopped");
}

/// Returns true if Ctrl-C must be ignored, and prints the reason: an operator's request to end the run is pending, or
/// this is the first Ctrl-C while the chamber is being made safe.
bool rejects_interrupt(const ActiveRun& run) {
  if (run.run_controller.is_end_requested()) {
    run.console.print_message(
        "an operator has already ended the run; a second Ctrl-C leaves the remaining steps to the guard");
    return true;
  }
  if (run.run_controller.run_state() != RunState::aborting || stops() > 1) return false;
  run.console.print_message(
      "the chamber has not yet confirmed its safe set point; a second Ctrl-C leaves the remaining steps to the guard");
  return true;
}

/// Ends without waiting for the chamber: the watchdog continues to make it safe.
Result<run::RunOutcome> leave_to_guard(const ActiveRun& run) {
  await_disk(run);
  return failure(FaultKind::interlock, "", run.run_controller.end_cause());
}

/// Prints alarms and changes of state immediately, each on its own line.
void print_events(const ActiveRun& run) {
  for (const auto& event : run.run_controller.last_events()) switch (event.kind) {
      case EventKind::fault:
      case EventKind::recovered:
      case EventKind::interlock:
      case EventKind::state:
        run.console.print_message(fmt::format("{} {}: {}", civil_time(event.at.utc), name(event.kind), event.text));
        break;
      default: break;
    }
}

/// Prints the last tick's second for programs that requested each second.
void print_sample(const ActiveRun& run) {
  if (!run.console.samples || run.run_controller.last().slot + 1 != run.run_controller.next_slot()) return;
  run.console.print_fact([&](std::size_t) {
    return sample_json(run.run_controller.last(), run.run_controller.last_events(), run.store.info()) + "\n";
  });
}

/// Real-time tick and the actions after it. None of them waits for a person, a terminal, a disk or a lock.
class RealTime {
 public:
  explicit RealTime(const ActiveRun& run)
      : run_(run),
        display_(run.console, run.profile, run.rig.file(), is_simulated(run.store.info())),
        control_socket_(open_control_socket(run)),
        mark_(run.path) {
    timer_.setTimerType(Qt::PreciseTimer);
    timer_.setSingleShot(true);
    timer_.callOnTimeout([this] { tick(); });
  }

  Result<run::RunOutcome> run() {
    QSocketNotifier interrupt(interrupt_descriptor(), QSocketNotifier::Read);
    QObject::connect(&interrupt, &QSocketNotifier::activated, [this] { handle_signal(); });
    QSocketNotifier requests(control_socket_ ? control_socket_->descriptor() : interrupt_descriptor(),
                             QSocketNotifier::Read);
    requests.setEnabled(control_socket_.has_value());
    QObject::connect(&requests, &QSocketNotifier::activated, [this] {
      if (!ended_) handle_requests(run_, control_socket_);
    });
    arm();
    QCoreApplication::exec();
    return result_;
  }

 private:
  /// Starts the timer for the next whole second of the rig's clock: slot k is ticked at its end, k + 1 s.
  void arm() {
    const auto now = run_.rig.clock().now().since_start;
    const auto next_second = std::chrono::floor<std::chrono::seconds>(now) + std::chrono::seconds(1);
    timer_.start(std::chrono::ceil<std::chrono::milliseconds>(next_second - now));
  }

  /// Ends the loop. Qt may still deliver pending events afterwards; `ended_` keeps them from recording anything.
  void end(Result<run::RunOutcome> result) {
    ended_ = true;
    timer_.stop();
    result_ = std::move(result);
    QCoreApplication::quit();
  }

  /// Waits for the disk and syncs, so the last seconds are acknowledged, too.
  Result<run::RunOutcome> sync_last_second(Result<run::RunOutcome> outcome) {
    await_disk(run_);
    if (const auto synced = sync(run_); !synced && outcome) return failure(synced.error());
    return outcome;
  }

  /// Reacts to a closed terminal as the rig file requires. A user may close a terminal and still want the run to
  /// continue.
  void handle_hangup() {
    if (count_hangups() == seen_hangups_) return;
    seen_hangups_ = count_hangups();
    discard_hangups();
    if (run_.rig.file().run_limits.on_hangup == interlocks::OnHangup::go_on)
      run_.run_controller.note(EventKind::note, "the terminal was closed; the run and its guard continue");
    else if (run_.run_controller.refusal_reason(control::OperatorCommand::abort).empty())
      run_.run_controller.submit(control::OperatorCommand::abort, "closed terminal");
  }

  /// Returns true after a SIGTERM that must leave the chamber safe. A shutdown does not wait: the watchdog takes over.
  [[nodiscard]] bool is_terminated() const {
    return count_terminations() > 0 && run_.rig.file().run_limits.on_stop == interlocks::OnStop::safe;
  }

  void handle_signal() {
    drain_wake_ups();
    if (ended_) return;
    handle_hangup();
    handle_requests(run_, control_socket_);  // earlier requests outrank Ctrl-C
    if (is_terminated() && !run_.ownership.troubles().empty()) return abort_without_guard();
    if (stops() == 0 || (!is_terminated() && rejects_interrupt(run_))) return;
    leaves_after_tick_ = run_.run_controller.has_pending_work() && stops() == 1;  // pending work is completed first
    if (!leaves_after_tick_) leave();
  }

  /// Requests an abort. The program ends only when the chamber is confirmed safe, because no watchdog could take over.
  void abort_without_guard() {
    run_.console.print_message("no guard monitors the chamber; this program ends when the chamber is safe");
    if (run_.run_controller.refusal_reason(control::OperatorCommand::abort).empty())
      run_.run_controller.submit(control::OperatorCommand::abort, "SIGTERM");
  }

  void leave() {
    if (run_.run_controller.run_state() == RunState::aborting) return end(leave_to_guard(run_));
    if (!is_terminated()) return end(finish_stopped(run_));
    run_.run_controller.make_safe("stopped by SIGTERM");
    run_.ownership.heartbeat({});  // before waiting for the disk
    if (run_.ownership.troubles().empty()) return end(finish_terminated(run_));
    arm();  // no watchdog: end when confirmed
  }

  void tick() {
    if (ended_) return;
    handle_requests(run_, control_socket_);
    const auto slot = run_.rig.clock().now().since_start / std::chrono::seconds(1) - 1;
    if (slot >= run_.run_controller.next_slot()) {
      run_.run_controller.set_guard_troubles(run_.ownership.troubles());
      auto outcome = run_.run_controller.tick(slot);
      run_.ownership.heartbeat(run_.rig.io().stuck_for());
      mark_.follow(run_.run_controller.run_state());
      if (const auto decided = outcome ? decide_if_due(run_) : Result<void>(); !decided)
        outcome = failure(decided.error());
      if (const auto synced = sync(run_); !synced && outcome) outcome = failure(synced.error());
      display_.add_sample(run_.run_controller.last());
      print_events(run_);
      print_sample(run_);
      display_.show(run_.run_controller.last(), overview_with_disk_faults(run_), run_.store.alarms().list(),
                    goal_line(run_));
      if (!outcome || *outcome != run::RunOutcome::going_on) return end(sync_last_second(std::move(outcome)));
      if (std::exchange(leaves_after_tick_, false) && (is_terminated() || !rejects_interrupt(run_))) return leave();
    }
    arm();
  }

  const ActiveRun& run_;
  Display display_;
  std::optional<control::ControlSocket> control_socket_;
  OperatorMark mark_;
  QTimer timer_;
  bool ended_ = false;
  bool leaves_after_tick_ = false;
  int seen_hangups_ = 0;
  Result<run::RunOutcome> result_ = run::RunOutcome::going_on;  ///< set when the run has ended
};

/// Waits until `due` and carries out requests that arrive. Returns early if a signal arrives.
void await_second(const ActiveRun& run, std::optional<control::ControlSocket>& control_socket,
                  steady_clock::time_point due) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - steady_clock::now());
    if (left.count() <= 0) return;
    std::array<pollfd, 2> descriptors{{{interrupt_descriptor(), POLLIN, 0}, {-1, POLLIN, 0}}};
    if (control_socket) descriptors[1].fd = control_socket->descriptor();
    ::poll(descriptors.data(), descriptors.size(), static_cast<int>(left.count()));
    if (descriptors[0].revents != 0) return drain_wake_ups();
    handle_requests(run, control_socket);
  }
}

}  // namespace

void await_disk(const ActiveRun& run) {
  if (run.store.settle(kLongestFlush)) return;
  const auto health = run.store.health();
  run.console.print_message(fmt::format("warning: {} s are not on disk: {}", health.backlog_s, health.trouble));
}

bool await_end_on_disk(const ActiveRun& run) {
  constexpr Duration kReportInterval = std::chrono::minutes(1), kPollInterval = std::chrono::milliseconds(500);
  const auto stops_before = stops();
  // The guard ends a program without a heartbeat.
  const auto is_on_disk = [&] {
    run.ownership.heartbeat({});
    return run.store.settle(kPollInterval);
  };
  for (const Deadline flush(kLongestFlush); !flush.has_passed();)
    if (is_on_disk()) return true;
  for (std::optional<Deadline> next_report; !is_on_disk();) {
    const auto health = run.store.health();
    const auto missing = fmt::format("{} s are not on disk: {}", health.backlog_s, health.trouble);
    if (stops() > stops_before) {
      run.console.print_message(
          fmt::format("warning: {}; THE END OF THE RUN IS NOT IN THE RECORD: do not resume it unasked", missing));
      return false;
    }
    if (next_report && !next_report->has_passed()) continue;
    next_report.emplace(kReportInterval);
    run.console.print_message(
        fmt::format("warning: {}; the program waits for the disk; Ctrl-C ends it without these seconds", missing));
  }
  return true;
}

Result<run::RunOutcome> drive_virtual(const ActiveRun& run) {
  Display display(run.console, run.profile, run.rig.file(), is_simulated(run.store.info()));
  auto control_socket = open_control_socket(run);
  Pacer pacer(run.pace);
  auto last_sync = steady_clock::now();
  for (;;) {
    run.rig.let_pass(1);
    const auto outcome = run.run_controller.tick(run.run_controller.next_slot());
    if (!outcome) return outcome;
    if (const auto decided = decide_if_due(run); !decided) return failure(decided.error());
    display.add_sample(run.run_controller.last());
    print_sample(run);
    const bool ended = *outcome != run::RunOutcome::going_on;
    const bool is_paused = run.run_controller.is_paused_by_operator();
    const bool checks_clock = run.run_controller.next_slot() % kTicksPerClockCheck == 0;
    if (!ended && run.pace == 0 && !is_paused && !checks_clock) continue;
    if (interrupted() && !ended && !run.run_controller.is_end_requested() &&
        (run.run_controller.run_state() != RunState::aborting || interrupts() > 1))
      return finish_stopped(run);
    handle_requests(run, control_socket);
    if (ended || steady_clock::now() - last_sync >= kLongestBatch) {
      if (auto synced = sync(run); !synced) return failure(synced.error());
      last_sync = steady_clock::now();
      display.show(run.run_controller.last(), overview_with_disk_faults(run), run.store.alarms().list(),
                   goal_line(run));
    }
    if (ended) return outcome;
    if (const auto due = pacer.next_second(steady_clock::now(), is_paused)) await_second(run, control_socket, *due);
  }
}

Result<run::RunOutcome> drive_real(const ActiveRun& run) {
  int argc = 0;
  QCoreApplication application(argc, nullptr);
  return RealTime(run).run();
}

}  // namespace gyrotherm::app
