// SPDX-License-Identifier: Apache-2.0
#include "sequencer/prove/make_safe_proof.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "drivers/supply/safety_relay.hpp"
#include "sequencer/prove/driven_child.hpp"
#include "sequencer/watchdog/safe_evidence.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::prove {
namespace {

constexpr Kelvins kTestStep{5};
constexpr Duration kPollEvery = std::chrono::milliseconds(200);
constexpr Duration kReturnWithin = std::chrono::minutes(2);

/// Interval of readings on a line that the guard cannot use meanwhile.
constexpr Duration kExclusivePollEvery = std::chrono::seconds(1);

std::string describe(const ChamberState& state) {
  const auto set_point =
      std::isnan(state.set_point.value) ? std::string("unreadable") : fmt::format("{:g} °C", state.set_point.value);
  return fmt::format("set point {}, air {:.2f} °C, {}", set_point, state.air.value, name(state.activity));
}

/// Watches a chamber from outside and the trace of its guard. On a line that only one program can use, the chamber is
/// read only after the guard has left its first trace, and less often.
class GuardDrill {
 public:
  GuardDrill(ProofTest test, const rig::RigFile& rig, const std::string& record, const DrillEnvironment& environment,
             const GuardTimes& limits)
      : times(limits),
        rig_(rig),
        record_(record),
        environment_(environment),
        is_exclusive_(is_exclusive_line(rig)),
        goal_(watchdog::safe_goal(rig.chamber_map, rig.safe_set_point, {})),
        log(test, environment) {}

  const GuardTimes times;

  /// Lets time pass until `is_true` holds. Returns the time, or nothing after `within`.
  std::optional<double> await(Duration within, const std::function<bool()>& is_true) {
    const auto every = is_exclusive_ ? kExclusivePollEvery : kPollEvery;
    for (const double began = log.passed_s();; environment_.wait(every)) {
      if (is_true()) return log.passed_s() - began;
      if (log.passed_s() - began > to_seconds(within)) return std::nullopt;
    }
  }

  std::optional<ChamberState> look() {
    const auto state = environment_.connect()->inspect();
    last_ = state ? describe(*state) : text(state.error());
    is_answering_ = state.has_value();
    return state ? std::optional(*state) : std::nullopt;
  }
  bool shows(Celsius set_point) {
    const auto state = look();
    return state && std::abs((state->set_point - set_point).value) <= set_point_tolerance(rig_.chamber_map).value;
  }
  /// Returns true if the chamber shows the safe set point and a safe mode. If the set point cannot be read back, the
  /// guard's trace must state that the chamber acknowledged it.
  bool is_safe() {
    if (is_exclusive_ && !trace()) return false;
    const auto state = look();
    if (!state) return false;
    watchdog::SafeEvidence evidence(goal_);
    if (!goal_.reads_back && is_acknowledged()) evidence.acknowledge(watchdog::SafeAction::set_point);
    evidence.add_reading(*state, {});
    return evidence.has_shown_set_point() && evidence.has_shown_mode();
  }

  std::optional<watchdog::MadeSafe> trace() const {
    const auto found = watchdog::read_trace(record_);
    return found && *found ? *found : std::optional<watchdog::MadeSafe>();
  }
  /// Describes what the guard left, for causes.
  [[nodiscard]] std::string guard_words() const {
    const auto found = trace();
    return found ? describe(*found) : "the guard left no trace: it did not act";
  }
  /// Waits until the guard confirms that the chamber is safe. Returns the cause of a failure.
  std::string await_confirmation() {
    const auto confirmed = await(rig_.safe_observe + times.confirm, [&] {
      const auto found = trace();
      return found && found->confirmed;
    });
    if (!confirmed) return "the guard did not confirm that the chamber is safe: " + guard_words();
    log.read("confirmed by the guard after", fmt::format("{:.1f} s", *confirmed));
    return "";
  }
  /// Waits until the guard of a dead program needs the chamber's line no more. Returns false if it may still need it.
  bool await_guard() {
    // No guard was armed before the program died.
    if (watchdog::was_released(record_)) return true;
    const auto cause =
        await(times.safe, [&] { return trace().has_value(); }) ? await_confirmation() : "it left no trace";
    if (!cause.empty()) log.read("guard reports", cause);
    return cause.empty();
  }
  [[nodiscard]] const std::string& last() const { return last_; }
  [[nodiscard]] bool is_answering() const { return is_answering_; }
  [[nodiscard]] bool is_exclusive() const { return is_exclusive_; }
  /// Returns whether a new connection can read the set point.
  [[nodiscard]] bool reads_back() const { return goal_.reads_back; }

 private:
  [[nodiscard]] bool is_acknowledged() const {
    const auto found = trace();
    return found && found->details.find(watchdog::shown_set_point(goal_)) != std::string::npos;
  }

  const rig::RigFile& rig_;
  const std::string& record_;
  const DrillEnvironment& environment_;
  const bool is_exclusive_;
  const watchdog::SafeGoal goal_;
  std::string last_ = "not read";
  bool is_answering_ = false;

 public:
  DrillLog log;
};

/// Starts the program and waits until the chamber shows its set point. On an exclusive line only the program can read
/// it, and some chambers only acknowledge it.
Result<DrivenChild> start_and_watch(const rig::RigFile& driven, const std::string& record, Celsius set_point,
                                    GuardDrill& drill) {
  auto child = DrivenChild::start(driven, record, set_point);
  if (!child) return child;
  const bool can_look = !drill.is_exclusive() && drill.reads_back();
  if (can_look && !drill.await(drill.times.show, [&] { return drill.shows(set_point); }))
    return failure(FaultKind::mismatch, "child run", "the chamber did not show its set point: " + drill.last());
  drill.log.read("program drives the chamber to", celsius_text(set_point));
  return child;
}

std::unique_ptr<drivers::SafetyRelay> make_rig_relay(const rig::RigFile& rig) {
  return rig.safe_also ? make_safety_relay(*rig.safe_also) : nullptr;
}

/// Waits until the guard has opened the relay. Returns the cause of a failure.
std::string await_relay(const rig::RigFile& rig, drivers::SafetyRelay& relay, GuardDrill& drill) {
  Result<drivers::RelayPosition> shown = drivers::RelayPosition::closed;
  const auto opened = drill.await(rig.safe_also->after + drill.times.relay, [&] {
    shown = relay.read();
    return shown && *shown == drivers::RelayPosition::open;
  });
  if (opened) {
    drill.log.read("relay opened by the guard after", fmt::format("{:.1f} s", *opened));
    return "";
  }
  return fmt::format("the guard did not open the relay: {}; {}", shown ? "it reads closed" : text(shown.error()),
                     drill.guard_words());
}

/// Waits until the guard reports that it cannot make the chamber safe. Returns the cause of a failure.
std::string await_report(GuardDrill& drill) {
  const auto reported = drill.await(drill.times.safe, [&] { return drill.trace().has_value(); });
  if (!reported) return drill.guard_words();
  if (drill.trace()->confirmed) return "the guard confirmed a chamber that it could not reach";
  drill.log.read("guard reports", "NOT yet made safe");
  return "";
}

/// Closes the relay that the guard opened. Returns the cause of a failure.
std::string close_relay(drivers::SafetyRelay& relay, const DrillEnvironment& environment, GuardDrill& drill) {
  if (const auto shown = relay.read(); shown && *shown == drivers::RelayPosition::closed) return "";
  const auto closed = switch_relay(relay, drivers::RelayPosition::closed, environment.wait);
  if (!closed) return "the relay could not be closed again: " + text(closed.error());
  drill.log.read("relay", "closed again");
  return "";
}

/// Waits until the chamber is safe on its returned line. With an open relay, a chamber without power is safe, too; the
/// relay is then closed and the chamber must become safe.
std::string await_return(const DrillEnvironment& environment, drivers::SafetyRelay* relay, GuardDrill& drill) {
  const auto safe = drill.await(drill.times.safe, [&] { return drill.is_safe(); });
  if (safe) drill.log.read("safe after the line returned", fmt::format("{:.1f} s; {}", *safe, drill.last()));
  const bool is_dark = !safe && relay != nullptr && !drill.is_answering();
  if (!safe && !is_dark)
    return fmt::format("the chamber was not safe {} after the line returned: {}; {}", format_duration(drill.times.safe),
                       drill.last(), drill.guard_words());
  if (relay != nullptr)
    if (auto cause = close_relay(*relay, environment, drill); !cause.empty()) return cause;
  if (safe || drill.await(kReturnWithin, [&] { return drill.is_safe(); })) return "";
  return "the chamber was not safe after the relay closed: " + drill.last();
}

}  // namespace

Result<Celsius> test_set_point(const rig::RigFile& rig) {
  // Both set points are read with the tolerance of the map.
  constexpr double kSeenTolerances = 2.5;
  const auto safe = rig.safe_set_point;
  const auto& limits = rig.chamber_limits;
  const auto warmer = std::min(safe + kTestStep, limits.highest), colder = std::max(safe - kTestStep, limits.lowest);
  const auto farther = warmer - safe >= safe - colder ? warmer : colder;
  const auto least = set_point_tolerance(rig.chamber_map) * kSeenTolerances;
  if (abs(farther - safe) >= least) return farther;
  return failure(FaultKind::usage, "set point of the test",
                 fmt::format("the chamber's limits of {:g} … {:g} °C leave no set point that differs visibly from the "
                             "safe one of {:g} °C: {:.2g} K is needed",
                             limits.lowest.value, limits.highest.value, safe.value, least.value));
}

ProofResult prove_make_safe(const rig::RigFile& rig, const std::string& record, const DrillEnvironment& environment,
                            const GuardTimes& times) {
  GuardDrill drill(ProofTest::make_safe, rig, record, environment, times);
  drill.log.limit("safe set point and mode after the program was killed", format_duration(times.safe));
  drill.log.limit("air observed by the guard", format_duration(rig.safe_observe));
  const auto set_point = test_set_point(rig);
  if (!set_point) return drill.log.end(ProofVerdict::not_tested, text(set_point.error()));
  auto child = start_and_watch(rig, record, *set_point, drill);
  const auto fail = [&](const std::string& cause) {
    (void)drill.await_guard();
    return drill.log.end(ProofVerdict::failed, cause);
  };
  if (!child) return fail(text(child.error()));
  child->kill();
  drill.log.read("program", "killed");
  const auto safe = drill.await(times.safe, [&] { return drill.is_safe(); });
  if (!safe)
    return fail(fmt::format("the chamber was not safe {} after the program was killed: {}; {}",
                            format_duration(times.safe), drill.last(), drill.guard_words()));
  drill.log.read("safe after", fmt::format("{:.1f} s; {}", *safe, drill.last()));
  const auto cause = drill.await_confirmation();
  if (!cause.empty()) return drill.log.end(ProofVerdict::failed, cause);
  return drill.log.end(environment.is_interrupted() ? ProofVerdict::interrupted : ProofVerdict::passed,
                       environment.is_interrupted() ? "stopped by the operator" : "");
}

ProofResult prove_line(const rig::RigFile& rig, const std::string& record, const DrillEnvironment& environment,
                       const GuardTimes& times) {
  GuardDrill drill(ProofTest::line, rig, record, environment, times);
  const auto parsed = drivers::parse_line(rig.chamber_line);
  const auto* tcp = parsed ? std::get_if<drivers::TcpLine>(&*parsed) : nullptr;
  if (tcp == nullptr)
    return drill.log.end(ProofVerdict::not_tested, "the chamber is not on a TCP line, and only such a line is cut");
  drivers::TcpLine to = *tcp;
  if (to.port == 0) to.port = rig.chamber_map.link.modbus.port;
  auto line = CuttableLine::open(to);
  if (!line) return drill.log.end(ProofVerdict::not_tested, text(line.error()));
  auto driven = rig;
  driven.chamber_line = fmt::format("tcp://127.0.0.1:{}", line->port());
  const auto relay = make_rig_relay(rig);
  if (relay)
    drill.log.limit("relay open after the guard began to act", format_duration(rig.safe_also->after + times.relay));
  drill.log.limit("safe set point and mode after the line returned", format_duration(times.safe));
  const auto set_point = test_set_point(rig);
  if (!set_point) return drill.log.end(ProofVerdict::not_tested, text(set_point.error()));
  auto child = start_and_watch(driven, record, *set_point, drill);
  // The guard of a dead program reaches the chamber only through the forwarder.
  const auto fail = [&](const std::string& cause) {
    if (!drill.await_guard()) line->leave_to_guard();
    return drill.log.end(ProofVerdict::failed, cause);
  };
  if (!child) return fail(text(child.error()));
  line->cut();
  child->kill();
  drill.log.read("line and program", "line cut, program killed");
  auto cause = relay ? await_relay(rig, *relay, drill) : await_report(drill);
  if (!relay) environment.wait(times.dead_line);
  line->restore();
  const auto returned = await_return(environment, relay.get(), drill);
  if (cause.empty()) cause = returned;
  if (!cause.empty()) return fail(cause);
  cause = drill.await_confirmation();
  if (!cause.empty()) line->leave_to_guard();
  return drill.log.end(cause.empty() ? ProofVerdict::passed : ProofVerdict::failed, cause);
}

ProofResult prove_relay(const rig::RigFile& rig, const DrillEnvironment& environment) {
  const std::string no_record;
  GuardDrill drill(ProofTest::relay, rig, no_record, environment, {});
  const auto relay = make_rig_relay(rig);
  if (!relay) return drill.log.end(ProofVerdict::not_tested, "the rig file has no [safe.also]");
  drill.log.limit("each position is read back within", "2 s");
  const auto fail = [&](const std::string& cause) { return drill.log.end(ProofVerdict::failed, cause); };
  if (const auto found = relay->read(); !found || *found == drivers::RelayPosition::open)
    return fail(found ? "the relay is open already" : "the relay cannot be read: " + text(found.error()));
  const auto opened = switch_relay(*relay, drivers::RelayPosition::open, environment.wait);
  if (!opened) {
    (void)switch_relay(*relay, drivers::RelayPosition::closed, environment.wait);
    return fail("the relay did not open: " + text(opened.error()));
  }
  drill.log.read("relay", "opened, reads open");
  (void)drill.look();
  drill.log.read("chamber", drill.last());
  const auto closed = switch_relay(*relay, drivers::RelayPosition::closed, environment.wait);
  if (!closed) return fail("the relay did not close again: " + text(closed.error()));
  drill.log.read("relay", "closed, reads closed");
  if (!drill.await(kReturnWithin, [&] { return drill.look().has_value(); }))
    return fail("the chamber does not answer after the relay closed: " + drill.last());
  drill.log.read("chamber", drill.last());
  return drill.log.end(ProofVerdict::passed);
}

std::string relay_refusal_reason(const rig::RigFile& rig, const std::string& rig_file) {
  const auto relay = make_rig_relay(rig);
  if (!relay) return "";
  const auto shown = relay->read();
  if (!shown) return fmt::format("the relay of [safe.also] cannot be read: {}", text(shown.error()));
  if (*shown == drivers::RelayPosition::closed) return "";
  return fmt::format(
      "the relay of [safe.also] is OPEN; find out why, then close it with \"gyrotherm prove {} "
      "--close-relay\"",
      rig_file);
}

}  // namespace gyrotherm::prove
