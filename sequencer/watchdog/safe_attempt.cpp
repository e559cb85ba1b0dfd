// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/safe_attempt.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>
#include <thread>
#include <utility>

#include "drivers/chamber/chamber_lock.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::watchdog {
namespace {

constexpr Duration kRetryInterval = std::chrono::milliseconds(300);
/// Retry interval for a chamber that answers, and keeps another set point.
constexpr Duration kRefusedInterval = std::chrono::seconds(2);
constexpr Duration kLastTryTime = std::chrono::seconds(8);
constexpr int kLaterStepTries = 3;
constexpr int kMaxQueries = 3;
/// The commands are sent without an answer after this many failed tries.
constexpr int kTriesUntilUnconfirmed = 3;

class Attempt {
 public:
  Attempt(const SafeGoal& goal, const AttemptEnvironment& environment, SafeTask task)
      : goal_(goal),
        environment_(environment),
        task_(task),
        began_(environment.clock.now().since_start),
        chamber_(environment.connect()) {}

  SafeAttempt carry_out() {
    if (task_ == SafeTask::look) return look();
    if (send_set_point())
      for (int i = 0; i < kLaterStepTries && done_.reached != SafeStage::all; ++i) leave_as_required();
    else
      switch_off_anyway();
    if (!done_.state && recognise_chamber() && inspect()) report(done_.reached, done_.details);
    return done_;
  }

 private:
  void report(SafeStage reached, std::string details) {
    done_.reached = std::max(done_.reached, reached);
    done_.details = std::move(details);
    environment_.report(done_);
  }

  /// Waits before a retry. Reconnects after a disconnect, because the old connection may still deliver the answer to an
  /// earlier request.
  void try_later(const Fault& fault) {
    report(done_.reached, text(fault));
    environment_.wait(fault.kind == FaultKind::mismatch ? kRefusedInterval : kRetryInterval);
    if (fault.kind == FaultKind::disconnected) chamber_ = environment_.connect();
    if (fault.kind == FaultKind::disconnected) is_recognised_ = false;
  }

  /// Fails with mismatch if another instrument answers; nothing is sent to that instrument. If a chamber does not
  /// answer this query, the set point is sent anyway, because the run has compared its identity before.
  [[nodiscard]] Result<void> recognise_chamber() {
    if (is_recognised_) return {};
    const auto identity = chamber_->recognise();
    const bool is_other =
        identity ? !goal_.identity.starts_with(*identity) && !goal_.identity.empty()
                 : identity.error().kind == FaultKind::mismatch || identity.error().kind == FaultKind::refused;
    is_other_ = is_other_ || is_other;
    if (is_other)
      return failure(FaultKind::mismatch, "chamber",
                     fmt::format("nothing is sent to another instrument: {}; the run began with: {}",
                                 identity ? *identity : text(identity.error()),
                                 goal_.identity.empty() ? "its map" : goal_.identity));
    is_recognised_ = identity.has_value();
    const bool is_repeated = !identity && ++unrecognised_ < kMaxQueries;
    return is_repeated ? failure(identity.error()) : Result<void>{};
  }

  [[nodiscard]] Result<void> send_once() {
    if (auto known = recognise_chamber(); !known) return known;
    if (!goal_.by_program) return chamber_->send_set_point_immediately(goal_.set_point);
    chamber_->end_rest();
    const auto ended = chamber_->end_program();
    return chamber_->send_set_point_immediately(goal_.set_point).and_then([&] { return ended; });
  }

  [[nodiscard]] bool send_set_point() {
    while (environment_.clock.now().since_start - began_ < kLastTryTime) {
      ++done_.tries;
      const auto sent = send_once();
      if (sent) {
        report(SafeStage::set_point, shown_set_point(goal_));
        return true;
      }
      try_later(sent.error());
      if (done_.tries % kTriesUntilUnconfirmed == 0) send_unconfirmed(sent.error());
    }
    return false;
  }

  /// Sends the commands to a chamber whose answers are missing or cannot be understood, if the run has identified it
  /// and no other instrument answers. This is no evidence, so the attempt fails anyway.
  void send_unconfirmed(const Fault& fault) {
    is_other_ = is_other_ || fault.kind == FaultKind::mismatch || fault.kind == FaultKind::refused;
    if (goal_.identity.empty() || is_other_) return;
    if (chamber_->send_safe_state_unconfirmed(goal_.set_point, must_be_off()))
      report(done_.reached, text(fault) + "; the commands were sent without waiting for an answer");
  }

  /// Reads the state, and keeps it as evidence even if a later command fails.
  [[nodiscard]] Result<ChamberState> inspect() {
    auto state = chamber_->inspect();
    if (state) done_.state = *state;
    return state;
  }

  SafeAttempt look() {
    for (int i = 0; i < kLaterStepTries && !done_.state; ++i) {
      const auto known = recognise_chamber();
      const auto state = known ? inspect() : failure(known.error());
      report(state ? SafeStage::all : SafeStage::nothing, state ? "read" : text(state.error()));
    }
    return done_;
  }

  /// Switches off a chamber that refuses the set point, if everything else had no effect.
  void switch_off_anyway() {
    if (task_ != SafeTask::off || !recognise_chamber()) return;
    if (const auto off = chamber_->stop(); !off) report(done_.reached, done_.details + "; " + text(off.error()));
  }

  [[nodiscard]] bool must_be_off() const { return goal_.switch_off || task_ == SafeTask::off; }

  /// Writes the mode of the safe state, and reads the chamber afterwards.
  [[nodiscard]] Result<ChamberState> write_mode() {
    const auto switched = must_be_off() ? chamber_->stop() : Result<void>();
    const auto state = inspect();
    if (!switched) return failure(switched.error());
    const bool wrong = state && (state->activity == ChamberActivity::not_following ||
                                 state->activity == ChamberActivity::done || is_program_activity(state->activity));
    if (must_be_off() || !(wrong || task_ == SafeTask::follow)) return state;
    if (auto started = chamber_->start(); !started) return failure(started.error());
    return inspect();
  }

  /// Returns the chamber's description of its safe state, once nothing overrides the set point.
  [[nodiscard]] Result<std::string> settle() {
    chamber_->end_rest();
    if (auto known = recognise_chamber(); !known) return failure(known.error());
    if (auto ended = chamber_->end_program(); !ended) return failure(ended.error());
    if (auto sent = chamber_->send_set_point_immediately(goal_.set_point); !sent) return failure(sent.error());
    const auto state = write_mode();
    if (!state) return failure(state.error());
    if (!std::isnan(state->set_point.value) && abs(state->set_point - goal_.set_point) > goal_.tolerance)
      return failure(FaultKind::mismatch, "chamber set point",
                     fmt::format("reads {:g} after {:g} was written", state->set_point.value, goal_.set_point.value));
    return fmt::format("{}, air {:.2f} °C{}", shown_set_point(goal_), state->air.value,
                       must_be_off() ? ", conditioning switched off" : "");
  }

  void leave_as_required() {
    const auto settled = settle();
    if (settled) return report(SafeStage::all, *settled);
    try_later({settled.error().kind, "", fmt::format("{}, but {}", shown_set_point(goal_), text(settled.error()))});
  }

  const SafeGoal& goal_;
  const AttemptEnvironment& environment_;
  SafeTask task_;
  Duration began_;
  std::unique_ptr<drivers::Chamber> chamber_;
  bool is_recognised_ = false;
  int unrecognised_ = 0;   ///< queries without an answer
  bool is_other_ = false;  ///< another instrument answered
  SafeAttempt done_;
};

constexpr Duration kLaterStepTime = std::chrono::seconds(30);

/// Returns the file name of a process' program, also of a removed file; "" if this user has no permission.
std::string program_name(std::int64_t pid) {
  constexpr std::string_view kRemoved = " (deleted)";
  std::error_code error;
  auto name = std::filesystem::read_symlink(fmt::format("/proc/{}/exe", pid), error).filename().string();
  if (name.ends_with(kRemoved)) name.resize(name.size() - kRemoved.size());
  return name;
}

constexpr std::string_view kMakeSafeProgram = "gyrotherm-make-safe";

/// Returns true if the holder has taken the chamber over legitimately: a program of this user or of root, and not the
/// one that died. A stopped program neither drives the chamber nor makes it safe.
bool is_successor(const drivers::ChamberHolder& holder, const std::string& program, const SafeState& safe_state) {
  if (holder.pid == 0 || holder.pid == safe_state.written_by.pid || holder.pid == ::getpid()) return false;
  if (holder.uid != 0 && holder.uid != ::geteuid()) return false;
  if (is_stopped(holder.pid)) return false;
  constexpr std::array<std::string_view, 2> kOwn{"gyrotherm", kMakeSafeProgram};
  return program.empty() || std::ranges::count(kOwn, program) > 0;
}

/// Returns "STAGE STATE AIR SET_POINT ACTIVITY DETAILS"; STATE is 0 if none was read.
std::string to_line(const SafeAttempt& attempt) {
  auto details = attempt.details;
  std::replace(details.begin(), details.end(), '\n', ' ');
  const auto state = attempt.state.value_or(ChamberState{});
  return fmt::format("{} {} {} {} {} {}", static_cast<int>(attempt.reached), attempt.state ? 1 : 0, state.air.value,
                     state.set_point.value, static_cast<int>(state.activity), details);
}

/// Removes the first number from the line and returns it; NaN if there is none.
double take_number(std::string_view& line) {
  const auto end = std::min(line.find(' '), line.size());
  double value = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(line.data(), line.data() + end, value);
  line.remove_prefix(std::min(end + 1, line.size()));
  return value;
}

void take(const std::string& line, RescueResult& rescued) {
  std::string_view left = line;
  const double stage = take_number(left);
  if (!(stage >= 0 && stage <= static_cast<double>(SafeStage::all))) return;
  rescued.reached = static_cast<SafeStage>(static_cast<int>(stage));
  const bool has_state = take_number(left) == 1;
  const Celsius air{take_number(left)}, set_point{take_number(left)};
  const double activity = take_number(left);
  const bool known = activity >= 0 && activity <= static_cast<double>(ChamberActivity::unknown);
  if (has_state && known)
    rescued.state = ChamberState{air, set_point, static_cast<ChamberActivity>(static_cast<int>(activity))};
  rescued.details = left;
}

void carry_out(const SafeStateChamber& chamber, SafeTask task, const ChildWork::SendLine& send_line) {
  const SteadyClock clock;
  (void)attempt_safe(chamber.goal,
                     {.connect = chamber.connect,
                      .wait = [](Duration time) { std::this_thread::sleep_for(time); },
                      .report = [&](const SafeAttempt& attempt) { send_line(to_line(attempt)); },
                      .clock = clock},
                     task);
}

}  // namespace

SafeAttempt attempt_safe(const SafeGoal& goal, const AttemptEnvironment& environment, SafeTask task) {
  return Attempt(goal, environment, task).carry_out();
}

Result<SafeStateChamber> make_safe_state_chamber(const SafeState& safe_state) {
  const auto where = safe_state_path(safe_state.record);
  const auto line = drivers::parse_line(safe_state.line);
  if (!line || !drivers::is_byte_line(*line))
    return failure(FaultKind::bad_file, where, "its line does not lead to a chamber");
  const bool is_serial = std::holds_alternative<drivers::SerialLine>(*line);
  const bool may_be_either = safe_state.link == drivers::LinkKind::text_serial;
  if (!may_be_either && is_serial != (safe_state.link == drivers::LinkKind::rtu))
    return failure(FaultKind::bad_file, where,
                   fmt::format("link \"{}\" does not fit line {}", name(safe_state.link), safe_state.line));
  auto map =
      parse_register_map(safe_state.map_text, where + " (register map)", safe_state.word_order, safe_state.parameters);
  if (!map) return failure(map.error());
  const auto linked =
      select_link(std::move(*map), safe_state.link)
          .and_then([&](auto on_its_link) { return select_power_switch(std::move(on_its_link), safe_state.power); })
          .and_then([&](auto powered) { return apply_settings(std::move(powered), safe_state.link_settings); });
  if (!linked) return failure(FaultKind::bad_file, where, linked.error().what);
  auto goal = safe_goal(*linked, safe_state.safe_set_point, safe_state.observe);
  goal.switch_off = safe_state.switch_off;
  goal.by_program = safe_state.by_program;
  goal.identity = safe_state.identity;
  return SafeStateChamber{
      .place = drivers::chamber_lock_name(*line, linked->link.modbus.port, linked->link.modbus.unit),
      .goal = goal,
      .connect = [map = *linked, line = *line, settings = safe_state.settings] {
        return make_modbus_chamber(map, make_registers(line, map), drivers::make_real_pauses(), settings);
      }};
}

RescueResult attempt_once(const SafeState& safe_state, const SafeStateChamber& chamber, GuardPost& post, SafeTask task,
                          Duration at_most) {
  const auto lock = drivers::ChamberLock::take(chamber.place, safe_state.record + std::string(kMadeSafeMark));
  if (auto successor = post.find_successor())
    return {.reached = {}, .details = {}, .in_use = true, .successor = std::move(*successor)};
  if (!lock && lock.error().kind == FaultKind::refused) {
    const auto holder = drivers::ChamberLock::holder(chamber.place);
    const auto program = holder ? program_name(holder->pid) : "";
    if (holder && is_successor(*holder, program, safe_state))
      return {.reached = {}, .details = {}, .in_use = true, .holder = holder->words};
  }
  RescueResult rescued{.reached = {}, .details = "the attempt returned no result", .in_use = false};
  ChildWork work([&](const auto& send_line) { carry_out(chamber, task, send_line); });
  const SteadyClock clock;
  for (Duration longest = kSafeWithin; !work.has_ended();) {
    const auto line = work.next(std::min(longest, at_most) - clock.now().since_start);
    if (!line) break;
    take(*line, rescued);
    if (rescued.reached != SafeStage::nothing) longest = kSafeWithin + kLaterStepTime;
  }
  if (!work.has_ended()) rescued.details += "; the attempt did not finish in time";
  return rescued;
}

SafeTask SafeRescue::task() const {
  if (!is_answering_ || evidence_.next() == SafeAction::set_point)
    return evidence_.is_ineffective() && evidence_.must_be_off() ? SafeTask::off : SafeTask::leave_as_required;
  switch (evidence_.next()) {
    case SafeAction::follow: return SafeTask::follow;
    case SafeAction::off: return SafeTask::off;
    default: return SafeTask::look;
  }
}

void SafeRescue::take(const RescueResult& rescued, SafeTask task) {
  if (task != SafeTask::look) {
    if (rescued.reached != SafeStage::nothing) evidence_.acknowledge(SafeAction::set_point);
    if (rescued.reached == SafeStage::all) evidence_.acknowledge(SafeAction::follow);
    if (rescued.reached == SafeStage::all && evidence_.must_be_off()) evidence_.acknowledge(SafeAction::off);
  }
  is_answering_ = rescued.state.has_value();
  failures_ = is_answering_ ? 0 : failures_ + 1;
  has_answered_ = has_answered_ || is_answering_;
  if (rescued.state) evidence_.add_reading(*rescued.state, since_boot());
}

RescueResult SafeRescue::attempt(Duration at_most) {
  const auto what = task();
  auto rescued = attempt_once(safe_state_, chamber_, post_, what, at_most);
  if (rescued.in_use && rescued.successor.empty() && std::exchange(holder_, rescued.holder) != rescued.holder)
    printer_.print("another program uses the chamber: " + rescued.holder);
  if (rescued.in_use) return rescued;
  take(rescued, what);
  const bool ineffective = evidence_.is_ineffective();
  rescued.is_ineffective = is_answering_ && ineffective;
  rescued.has_shown_commands = is_answering_ && evidence_.has_shown_set_point() && evidence_.has_shown_mode();
  if (is_answering_) {
    const bool is_refused = what != SafeTask::look && rescued.reached != SafeStage::all && !rescued.details.empty();
    rescued.details =
        (ineffective ? "safe_ineffective: " : "") + evidence_.describe() + (is_refused ? "; " + rescued.details : "");
  }
  if (!is_answering_)
    rescued.reached = std::min(rescued.reached, SafeStage::set_point);
  else if (!evidence_.is_safe())
    rescued.reached = evidence_.has_shown_set_point() ? SafeStage::set_point : SafeStage::nothing;
  return rescued;
}

Duration SafeRescue::pause() const {
  constexpr Duration kRetryPause = std::chrono::seconds(1), kLookPause = std::chrono::seconds(2);
  // A longer pause avoids flooding a controller that ignores commands.
  constexpr Duration kCommandPause = std::chrono::seconds(5);
  if (!is_answering_) return kRetryPause;
  return task() == SafeTask::look ? kLookPause : kCommandPause;
}

}  // namespace gyrotherm::watchdog
