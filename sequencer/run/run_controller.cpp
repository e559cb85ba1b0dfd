#include "sequencer/run/run_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/process.hpp"
#include "drivers/chamber/set_point_tolerance.hpp"
#include "sequencer/profile/timeline.hpp"
#include "sequencer/run/resume_rule.hpp"

namespace gyrotherm {
namespace {

constexpr Duration kTick = std::chrono::seconds(1);
constexpr int kSafeTries = 3;
constexpr std::int64_t kTakeOverEvery = 10;  ///< seconds, of a chamber that does not take set points

/// What is read once a second, by name, and its fault or null.
struct Channelled {
  std::string name;
  const Fault* fault;
};

std::vector<Channelled> faults_of(const Sample& sample, const std::vector<std::string>& names) {
  const auto of = [](const auto& reading) { return reading.value ? nullptr : &reading.value.error(); };
  std::vector<Channelled> faults{{"chamber", of(sample.chamber)}};
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    faults.push_back({i < names.size() ? "thermometer " + names[i] : fmt::format("thermometer {}", i + 1),
                      of(sample.thermometers[i])});
  faults.push_back({"gyro", of(sample.gyro)});
  return faults;
}

/// A driver's own place is told too, where it is more than the name.
std::string in_words(const Channelled& channel) {
  const auto& [kind, where, what] = *channel.fault;
  const bool adds_nothing = where.empty() || channel.name.ends_with(where);
  return adds_nothing ? fmt::format("{}: {}", channel.name, what)
                      : fmt::format("{}: {}: {}", channel.name, where, what);
}

std::string describe(const Profile& profile, const ProfilePosition& progress) {
  if (progress.phase == Phase::complete) return "profile complete";
  const auto& segment = profile.segments[static_cast<std::size_t>(progress.segment)];
  return fmt::format("segment {} of {}: {}", progress.segment + 1, profile.segments.size(), segment.name);
}

std::string in_words(const RunStateMachine& machine) {
  const auto cause = cause_of(machine);
  const std::string state = name(run_state(machine));
  return cause.empty() ? state : state + ": " + cause;
}

}  // namespace

RunController::RunController(const Profile& profile, Rig& rig, Store& store, ProfileState state,
                             std::int64_t first_slot)
    : profile_(profile),
      rig_(rig),
      store_(store),
      state_(std::move(state)),
      next_slot_(first_slot),
      path_(path_from(command(profile, state_))),
      safe_(rig.file()) {
  const auto all = plan(profile).all;
  planned_ = all.ramps + all.holds;
}

SetPointPath RunController::path_from(Celsius here) const {
  const auto& file = rig_.file();
  return {file.chamber_limits, set_point_tolerance(file.chamber_map), file.chamber_map.limits.every, here,
          kTick * next_slot_};
}

void RunController::begin_away(Celsius here, const std::string& cause, std::optional<Celsius> air_before) {
  path_ = path_from(here);
  approaching_ = true;
  air_before_ = air_before;
  change_to(Returning{cause, {}});
}

void RunController::note(EventKind kind, std::string text) {
  events_.push_back({rig_.clock().now(), kind, std::move(text)});
}

std::string RunController::objection(OperatorCommand command) const {
  const bool takes_over = command == OperatorCommand::resume && stands(InterlockId::foreign_set_point);
  if (takes_over && run_state() == RunState::suspended) return requests_.objection(RunState::held, command);
  if (command == OperatorCommand::resume && run_state() == RunState::held && !holds_.empty() && !takes_over)
    return "what holds it still stands: " + holds_;
  if (auto why = requests_.objection(run_state(), command); !why.empty()) return why;
  return watch_ && command == OperatorCommand::pause
             ? "the controller carries the profile out; only its panel can pause it"
             : "";
}

void RunController::tell(OperatorCommand command, const std::string& who) {
  requests_.add({command, who});
  note(EventKind::command, fmt::format("{} by {}", name(command), who));
}

std::optional<OperatorRequest> RunController::take_request() {
  auto taken = requests_.take();
  for (const auto& dropped : taken.dropped)
    note(EventKind::command,
         fmt::format("{} by {} is not carried out: {} by {} came within the same second", name(dropped.command),
                     dropped.who, name(taken.carried_out->command), taken.carried_out->who));
  return taken.carried_out;
}

/// A controller that carries the profile out goes on in the meantime.
Result<void> RunController::record_gap(std::int64_t slot) {
  if (slot <= next_slot_) return {};
  const auto missed = slot - next_slot_;
  note(EventKind::fault, fmt::format("{} s without a tick: the program was late", missed));
  if (watch_) state_ = next(profile_, state_, {.elapsed = kTick * missed, .air = air_});
  return store_.append_gap(std::exchange(next_slot_, slot), slot - 1, "the program was late");
}

void RunController::note_changes(const Sample& sample) {
  const auto all = faults_of(sample, rig_.file().limits.channels);
  faulty_.resize(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_faulty = all[i].fault != nullptr;
    if (is_faulty && !faulty_[i]) note(EventKind::fault, in_words(all[i]));
    if (!is_faulty && faulty_[i]) note(EventKind::recovered, all[i].name + " answers again");
    faulty_[i] = is_faulty;
  }
  if (sample.chamber.value && sample.chamber.value->alarms != alarms_) {
    alarms_ = sample.chamber.value->alarms;
    note(alarms_.empty() ? EventKind::recovered : EventKind::fault,
         alarms_.empty() ? "chamber: no alarm any more" : fmt::format("chamber alarm: {}", fmt::join(alarms_, "; ")));
  }
  if (sample.progress.segment != last_segment_) note(EventKind::segment, describe(profile_, sample.progress));
  last_segment_ = sample.progress.segment;
}

void RunController::note_alarms(const InterlockResult& result) {
  for (const auto& alarm : result.raised)
    note(alarm.reaction > Reaction::warn ? EventKind::interlock : EventKind::fault,
         fmt::format("{} ({}): {}", name(alarm.id), name(alarm.reaction), alarm.text));
  for (const auto& alarm : result.cleared)
    note(EventKind::recovered, fmt::format("{} is over: {}", name(alarm.id), alarm.text));
}

bool RunController::is_seen(InterlockId cause) const { return memory_.of(cause).samples > 0; }
bool RunController::stands(InterlockId cause) const { return is_seen(cause) && memory_.of(cause).raised; }

InterlockInputs RunController::inputs(const Sample& sample, Duration missed) const {
  InterlockInputs around;
  if (sample.chamber.value) around.sent = path_.expected(sample.chamber.value->set_point);
  around.set_point_tolerance = path_.tolerance();
  around.refusals = path_.refusals();
  around.refusal = path_.refusal();
  around.led_by_controller = watch_.has_value() || !may_command(run_state()) || run_state() == RunState::aborting;
  around.missed = missed;
  around.longest_missed = kLongestUnattended;
  const auto health = store_.health();
  around.backlog = std::chrono::seconds(health.backlog_s);
  around.rows_dropped = health.rows_dropped;
  around.storage_trouble = health.trouble;
  around.record_damage = health.damage;
  around.guard_trouble = guard_trouble_;
  return around;
}

/// What a controller does by itself goes on while an instrument is silent. After a pause of the program the resume rule
/// holds as after a restart.
InterlockDemand RunController::judge_second(const Sample& sample, Duration missed) {
  auto around = inputs(sample, missed);
  const bool last = sample.progress.segment + 1 >= static_cast<int>(profile_.segments.size());
  if (watch_) around.program = watch_->judge(sample.chamber, last, kTick + missed);
  auto result = judge(rig_.file().limits, std::move(memory_), sample, kTick + missed, around);
  memory_ = std::move(result.memory);
  note_alarms(result);
  auto& demand = result.demand;
  if (watch_ && demand.reaction < Reaction::abort) return {};
  const auto goal = command(profile_, state_);
  if (missed > Duration{} && air_ && sample.chamber.value && demand.reaction < Reaction::suspend &&
      abs(sample.chamber.value->air - goal) > abs(*air_ - goal) + kResumeBand) {
    approaching_ = true;
    demand = {Reaction::suspend, fmt::format("the air is at {:.2f} °C, before {} without a tick it was at {:.2f} °C",
                                             sample.chamber.value->air.value, spoken(missed), air_->value)};
  }
  return demand;
}

bool RunController::in_place(const Sample& sample) const {
  if (watch_) return true;
  const auto goal = command(profile_, state_);
  if (!path_.is_at(goal)) return false;
  if (!approaching_) return true;
  if (!sample.chamber.value) return false;
  return is_in_place(sample.chamber.value->air, goal, air_before_);
}

void RunController::change_to(RunStateMachine machine) {
  const auto before = run_state();
  const auto after = gyrotherm::run_state(machine);
  ensure(may_follow(before, after), "a run's states change along their table");
  const bool told =
      before != after || (std::holds_alternative<Returning>(machine) && !std::holds_alternative<Returning>(machine_));
  const auto why = cause_of(machine_);
  machine_ = std::move(machine);
  if (!told) return;
  const bool again = after == RunState::execute;
  note(EventKind::state, again && !why.empty() ? "execute: the profile goes on, after: " + why : in_words(machine_));
}

void RunController::step_machine(const Sample& sample, const InterlockDemand& demand, Duration elapsed) {
  holds_ = demand.reaction == Reaction::hold ? demand.cause : "";
  auto request = take_request();
  if (watch_ && request && request->command == OperatorCommand::pause) {
    note(EventKind::note, "it cannot be paused: the controller carries the profile out by itself");
    request.reset();
  }
  if (request && request->command == OperatorCommand::resume && stands(InterlockId::foreign_set_point))
    taking_over_ = true;
  if (run_state() == RunState::aborting) safe_.see(sample.chamber);
  const RunInputs now{.elapsed = elapsed,
                      .demand = demand,
                      .request = std::move(request),
                      .in_place = in_place(sample),
                      .safe_confirmed = safe_.is_confirmed(),
                      .complete = false};
  change_to(next(rig_.file().run_limits, machine_, now));
  if (run_state() == RunState::execute) approaching_ = false, air_before_.reset();
}

/// Of the sensor that the present segment soaks on.
Observation RunController::observation(const Sample& sample) const {
  const auto& sensor = soak_sensor(profile_, state_);
  Observation seen{.elapsed = kTick, .air = {}, .slope = {}};
  if (sensor == "air") {
    if (sample.chamber.value) seen.air = sample.chamber.value->air;
    seen.slope = memory_.air.rate();
    return seen;
  }
  const auto& channels = rig_.file().limits.channels;
  const auto column = static_cast<std::size_t>(std::find(channels.begin(), channels.end(), sensor) - channels.begin());
  if (column >= sample.thermometers.size()) return seen;
  if (const auto& reading = sample.thermometers[column].value) seen.air = *reading;
  seen.slope = memory_.thermometers[column].rate();
  return seen;
}

/// Which condition ended a soak, or that it has begun to wait.
void RunController::note_soak(const ProfilePosition& before) {
  const auto& segment = profile_.segments[static_cast<std::size_t>(before.segment)];
  if (!segment.guaranteed_soak) return;
  const auto now = position_of(profile_, state_);
  const auto what =
      fmt::format("±{:g} K of {:g} °C on {}", segment.soak_band.value, segment.target.value, segment.soak_sensor);
  if (now.phase == Phase::overdue && before.phase != Phase::overdue)
    return note(EventKind::note, fmt::format("soak of segment {} not ended: {} of {} inside {} when its deadline came",
                                             before.segment + 1, spoken(now.soaked), spoken(segment.soak_time), what));
  if (now.segment == before.segment && now.phase != Phase::complete) return;
  note(EventKind::note, fmt::format("soak of segment {} ended: {} inside {}, in {}", before.segment + 1,
                                    spoken(segment.soak_time), what, spoken(before.in_segment + kTick)));
}

void RunController::step_profile(const Sample& sample) {
  if (run_state() != RunState::execute) return;
  state_ = next(profile_, state_, observation(sample));
  note_soak(sample.progress);
  if (!std::holds_alternative<Complete>(state_)) return;
  change_to(
      next(rig_.file().run_limits, machine_, RunInputs{.elapsed = {}, .demand = {}, .request = {}, .complete = true}));
  note(EventKind::finished, "profile complete");
}

void RunController::send_set_point(Celsius goal) {
  ensure(may_command(run_state()), "a set point is sent only while the run is carried out");
  if (const auto sent = path_.go(rig_.sampler(), goal, kTick * (next_slot_ + 1)); !sent && path_.refusals() == 1)
    note(EventKind::fault, text(sent.error()));
}

/// The chamber is brought back from where it is: its set point to the air first, then it is switched on.
void RunController::take_over(const Sample& sample) {
  const auto& chamber = *sample.chamber.value;
  approaching_ = true;
  path_.adopt(chamber.set_point);
  path_.begin_at(chamber.air);
  const auto taken =
      path_.go(rig_.sampler(), within(chamber.air, rig_.file().chamber_limits), kTick * (next_slot_ + 1)).and_then([&] {
        return rig_.sampler().switch_on(true);
      });
  if (!taken) note(EventKind::fault, "taking the chamber over: " + text(taken.error()));
}

/// A silent chamber is not sent anything but what makes it safe.
void RunController::command_chamber(const Sample& sample) {
  const auto state = run_state();
  if (state == RunState::aborting) {
    if (const auto told = safe_.attempt(rig_.sampler(), kTick * next_slot_)) note(EventKind::fault, *told);
    return;
  }
  if (watch_ && state == RunState::stopped) {
    if (const auto held = rig_.sampler().command(command(profile_, state_)); !held)
      note(EventKind::fault, text(held.error()));
    return;
  }
  if (watch_ || !may_command(state) || !sample.chamber.value) return;
  const auto goal = command(profile_, state_);
  if (stands(InterlockId::restarted) || std::exchange(taking_over_, false)) return take_over(sample);
  if (stands(InterlockId::not_taken)) {
    if (next_slot_ % kTakeOverEvery == 0) take_over(sample);
    return;
  }
  if (is_seen(InterlockId::foreign_set_point))
    return;  // at the first poll too: what is not understood is not overwritten
  if (state == RunState::execute || std::holds_alternative<Returning>(machine_)) send_set_point(goal);
}

Outlook RunController::outlook() const {
  const auto left = time_left(profile_, state_);
  return {.state = run_state(),
          .cause = cause_of(machine_),
          .time_left = left,
          .behind_plan = std::max(Duration{}, kTick * next_slot_ - (planned_ - left)),
          .missed_set_points = path_.missed(),
          .faults = standing(memory_)};
}

std::string RunController::end_cause() const {
  const auto cause = cause_of(machine_);
  const bool safe = run_state() == RunState::aborting || run_state() == RunState::aborted || safe_.is_confirmed();
  return safe ? cause + "; " + safe_.words() : cause;
}

void RunController::make_safe(const std::string& cause) {
  if (!is_over(machine_) && run_state() != RunState::aborting) change_to(Aborting{cause, {}, false});
  for (int i = 0; i < kSafeTries && !safe_.is_confirmed(); ++i) {
    (void)safe_.attempt(rig_.sampler(), kTick * next_slot_);
    safe_.see(rig_.sampler().read(next_slot_, rig_.clock()).chamber);
  }
  note(EventKind::interlock, end_cause());
}

Result<RunOutcome> RunController::tick(std::int64_t slot) {
  const auto missed = kTick * (slot - next_slot_);
  if (auto recorded = record_gap(slot); !recorded) return failure(recorded.error());
  auto sample = rig_.sampler().read(slot, rig_.clock());
  sample.progress = position_of(profile_, state_);
  note_changes(sample);
  const auto demand = judge_second(sample, missed);
  step_machine(sample, demand, kTick + missed);
  sample.state = run_state();
  if (sample.chamber.value) air_ = sample.chamber.value->air;
  step_profile(sample);
  command_chamber(sample);
  if (run_state() == RunState::aborted) note(EventKind::interlock, end_cause());

  if (auto stored = store_.append(sample, events_); !stored) return failure(stored.error());
  last_events_ = std::exchange(events_, {});
  last_ = std::move(sample);
  next_slot_ = slot + 1;
  switch (run_state()) {
    case RunState::aborted: return RunOutcome::made_safe;
    case RunState::stopped: return RunOutcome::stopped;
    case RunState::complete: return RunOutcome::complete;
    default: return RunOutcome::going_on;
  }
}

}  // namespace gyrotherm
