// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/run_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/status.hpp"
#include "core/count_text.hpp"
#include "core/process.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/run/block_choice.hpp"
#include "sequencer/run/resume.hpp"

namespace gyrotherm::run {
namespace {

constexpr int kSafeTries = 3;
/// Longest observation of the air before a chamber is left at its set point.
constexpr Duration kLongestEndObservation = std::chrono::seconds(60);

std::string describe(const profile::Profile& profile, const ProfilePosition& progress) {
  if (progress.phase == Phase::complete) return "profile complete";
  const auto& segment = profile.segments[static_cast<std::size_t>(progress.segment)];
  return fmt::format("segment {} of {}: {}", progress.segment + 1, profile.segments.size(), segment.name);
}

std::string command_answer(OperatorCommand command) {
  switch (command) {
    case OperatorCommand::pause: return "held: the profile's clock and the set point stay unchanged until resume";
    case OperatorCommand::resume: return "continues";
    case OperatorCommand::stop: return "stops: ";
    case OperatorCommand::abort: return "aborts: ";
  }
  return "";
}

std::vector<std::string> unit_names(const rig::RigFile& rig) {
  std::vector<std::string> names;
  for (const auto& unit : rig.units) names.push_back(unit.info.name);
  return names;
}

std::string describe(const RunStateMachine& machine) {
  return record::describe(run_state(machine), state_cause(machine));
}

}  // namespace

RunController::RunController(const profile::Profile& profile, rig::Rig& rig, record::Store& store,
                             profile::ProfileState state, std::int64_t first_slot)
    : profile_(profile),
      rig_(rig),
      store_(store),
      state_(state),
      next_slot_(first_slot),
      lead_(std::make_unique<HostLead>(rig.file(), demanded_set_point(profile_, state_), kSecond * first_slot)),
      safe_(rig.file()),
      relay_(rig.file().simulated ? std::nullopt : rig.file().safe_also),
      dropped_(unit_names(rig.file()), rig.file().identification.unused),
      channels_(list_channels(rig.file())),
      changes_(rig.file()),
      power_(rig.file()) {
  planned_ = profile::total_time(profile_.segments);
}

void RunController::begin_away(Celsius here, const std::string& cause, std::optional<Celsius> air_before) {
  auto lead = std::make_unique<HostLead>(rig_.file(), here, kSecond * next_slot_);
  lead->begin_away(air_before);
  lead_ = std::move(lead);
  change_to(Returning{cause, {}});
}

void RunController::begin_behind(Celsius here) {
  lead_ = std::make_unique<HostLead>(rig_.file(), here, kSecond * next_slot_);
  note(EventKind::note,
       fmt::format("the set point ramps from the air temperature, {:.2f} °C, to the profile", here.value));
}

void RunController::note(EventKind kind, std::string text, EventSubject about) {
  if (!about.segment) about.segment = profile_position(profile_, state_).segment;
  events_.push_back({rig_.clock().now(), kind, std::move(text), std::move(about)});
}

bool RunController::takes_over(OperatorCommand command) const {
  return command == OperatorCommand::resume && !causes_ended_by_resume(memory_).empty();
}

std::string RunController::refusal_reason(OperatorCommand command) const {
  if (takes_over(command) && run_state() == RunState::suspended)
    return requests_.refusal_reason(RunState::held, command);
  if (auto why = requests_.refusal_reason(run_state(), command); !why.empty()) return why;
  return active_refusal_reason(command, takes_over(command));
}

std::string RunController::active_refusal_reason(OperatorCommand command, bool takes_over) const {
  const auto holds = command == OperatorCommand::resume ? active_cause(interlocks::Reaction::hold, takes_over) : "";
  return holds.empty() ? lead_->refusal_reason(command) : "the cause of the hold is still active: " + holds;
}

/// If the resume takes the chamber over, causes that such a resume ends are not considered.
std::string RunController::active_cause(interlocks::Reaction reaction, bool takes_over) const {
  const auto most = takes_over ? demand_without(memory_, causes_ended_by_resume(memory_)) : demand_;
  return most.reaction == reaction ? most.cause : "";
}

std::string RunController::answer_for(OperatorCommand command) const {
  const auto suspends = command == OperatorCommand::resume
                            ? active_cause(interlocks::Reaction::suspend, takes_over(command))
                            : std::string();
  if (!suspends.empty()) return "continues once this is over: " + suspends;
  const auto cold = command == OperatorCommand::resume ? std::string() : describe_cold_unit();
  const auto warning = cold.empty() ? cold : "; " + cold;
  if (command < OperatorCommand::stop) return command_answer(command) + warning;
  const auto* unconfirmed = last_.chamber.value ? "; \"gyrotherm status\" shows when it is confirmed safe"
                                                : ", but does not answer: it is NOT confirmed safe";
  const bool holds = command == OperatorCommand::stop && rig_.file().run_limits.on_stop == interlocks::OnStop::hold &&
                     leaving_refusal().empty();
  return command_answer(command) +
         (holds ? "the chamber holds its set point"
                : fmt::format("the chamber is sent to {:g} °C{}", rig_.file().safe_set_point.value, unconfirmed)) +
         warning;
}

void RunController::submit(OperatorCommand command, const std::string& who, const std::string& answer) {
  const bool ends = command >= OperatorCommand::stop;
  requests_.add({command, who, takes_over(command), ends ? answer : std::string()});
  note(EventKind::command, fmt::format("{} by {}{}{}", name(command), who, answer.empty() ? "" : ": ", answer));
}

control::ControlAnswer RunController::drop_or_return(const control::UnitRequest& request, const std::string& who,
                                                     const std::string& why) {
  const auto* word = request.drop ? "drop" : "return";
  auto reason =
      is_over(machine_) ? fmt::format("the run is over: {}", name(run_state())) : dropped_.refusal_reason(request);
  if (!reason.empty()) {
    note(EventKind::command, fmt::format("{}: {} {}, refused: {}", who, word, request.unit, reason));
    return {.done = false, .text = std::move(reason)};
  }
  dropped_.carry_out(request);
  note(request.drop ? EventKind::dropped : EventKind::returned,
       fmt::format("{} {} by {}{}{}", request.unit, request.drop ? "dropped" : "returned", who, why.empty() ? "" : ": ",
                   why),
       {.channel = request.unit});
  return {
      .done = true,
      .text = request.drop
                  ? request.unit + " is dropped: until it is returned, it is not recorded and the interlocks ignore it"
                  : request.unit + " is returned to the run"};
}

RunController::Acknowledged RunController::append_acknowledgements(const std::vector<std::int64_t>& numbers,
                                                                   const std::string& who, const std::string& comment) {
  Acknowledged result;
  const auto append = [&](const std::vector<record::Alarm>& rows) {
    for (const auto& row : rows) {
      const auto stored = store_.append_event(
          acknowledgement_event(row, rig_.clock().now(), profile_position(profile_, state_).segment, who, comment));
      if (!stored) result.refusals.push_back(text(stored.error()));
      (row.suppressed_by.empty() ? result.roots : result.consequences) += stored ? 1 : 0;
    }
  };
  if (numbers.empty()) append(store_.alarms().unacknowledged());
  for (const auto number : numbers) {
    auto reason = store_.alarms().refusal_reason(number);
    if (reason.empty()) append(store_.alarms().rows_for(number));
    if (!reason.empty()) result.refusals.push_back(std::move(reason));
  }
  return result;
}

control::ControlAnswer RunController::acknowledge(const std::vector<std::int64_t>& numbers, const std::string& who,
                                                  const std::string& comment) {
  auto [roots, consequences, refusals] = append_acknowledgements(numbers, who, comment);
  const auto count = roots + consequences;
  if (count == 0 && refusals.empty()) refusals.emplace_back("all alarms are acknowledged");
  const auto why = fmt::format("{}", fmt::join(refusals, "; "));
  if (!refusals.empty())
    note(EventKind::command, fmt::format("{}: acknowledge {}, refused: {}", who,
                                         numbers.empty() ? "all" : fmt::format("{}", fmt::join(numbers, ",")), why));
  if (count == 0) return {.done = false, .text = why};
  auto answer = roots > 0 ? format_count(roots, "alarm") : std::string();
  if (consequences > 0) answer += (roots > 0 ? " and " : "") + format_count(consequences, "consequence");
  answer += count == 1 ? " is acknowledged" : " are acknowledged";
  return {.done = true, .text = refusals.empty() ? std::move(answer) : fmt::format("{}; {}", answer, why)};
}

control::ControlAnswer RunController::shelve_or_unshelve(const control::ShelvingRequest& request,
                                                         const std::string& who, const std::string& reason) {
  const auto& alarms = store_.alarms();
  auto refusal = is_over(machine_) ? fmt::format("the run is over: {}", name(run_state()))
                 : request.time    ? alarms.shelving_refusal_reason(request.alarm)
                                   : alarms.unshelving_refusal_reason(request.alarm);
  const auto now = rig_.clock().now();
  const auto row = alarms.find_row(request.alarm);
  if (refusal.empty()) {
    const auto segment = profile_position(profile_, state_).segment;
    const auto stored =
        store_.append_event(request.time ? record::shelving_event(*row, now, segment, *request.time, who, reason)
                                         : record::unshelving_event(*row, now, segment, " by " + who));
    if (!stored) refusal = text(stored.error());
  }
  if (!refusal.empty()) {
    note(EventKind::command,
         fmt::format("{}: {} {}, refused: {}", who, request.time ? "shelve" : "unshelve", request.alarm, refusal));
    return {.done = false, .text = std::move(refusal)};
  }
  if (request.time)
    return {.done = true,
            .text = fmt::format("alarm {} is shelved until {}", request.alarm, civil_time(now.utc + *request.time))};
  return {.done = true,
          .text = fmt::format("alarm {} is unshelved{}", request.alarm,
                              row->active ? "; it is active and awaits an acknowledgement" : "")};
}

/// Records the end of each shelving whose time is over, or whose alarm demands more than a warning in this second.
void RunController::note_ended_shelvings() {
  const auto now = rig_.clock().now();
  for (const auto& row : store_.alarms().shelved()) {
    const auto is_severe = [&](const Event& event) {
      return event.kind == EventKind::interlock && event.about.interlock == row.interlock &&
             event.about.channel == row.subject;
    };
    const auto* cause = now.since_start >= row.shelved_until      ? ": the time is over"
                        : std::ranges::any_of(events_, is_severe) ? ": it is no longer a warning"
                                                                  : nullptr;
    if (cause != nullptr)
      events_.push_back(record::unshelving_event(row, now, profile_position(profile_, state_).segment, cause));
  }
}

control::ControlAnswer RunController::carry_out(const control::ControlRequest& request, const std::string& who) {
  if (request.unit) return drop_or_return(*request.unit, who, request.note);
  if (request.acknowledgement) return acknowledge(request.acknowledgement->alarms, who, request.note);
  if (request.shelving) return shelve_or_unshelve(*request.shelving, who, request.note);
  if (!request.command) {
    note(request.told ? EventKind::told : EventKind::note, who + ": " + request.note);
    return {.done = true, .text = "noted"};
  }
  if (auto why = refusal_reason(*request.command); !why.empty()) {
    note(EventKind::command, fmt::format("{}: {}, refused: {}", who, name(*request.command), why));
    return {.done = false, .text = std::move(why)};
  }
  submit(*request.command, who, request.note);
  return {.done = true, .text = answer_for(*request.command)};
}

std::optional<OperatorRequest> RunController::take_request() {
  auto taken = requests_.take();
  for (const auto& dropped : taken.dropped)
    note(EventKind::command,
         fmt::format("{} by {} is not carried out: {} by {} had priority in the same second", name(dropped.command),
                     dropped.who, name(taken.carried_out->command), taken.carried_out->who));
  return taken.carried_out;
}

/// Records the slots without a tick as a gap. If a controller executes the profile, advances the profile over the gap,
/// unless the chamber is being made safe. The air in the gap is unknown: it is assumed to follow the set point if the
/// machine slept, and to be unchanged otherwise.
Result<void> RunController::record_gap(std::int64_t slot) {
  waited_for_chamber_ = false;
  if (slot <= next_slot_) return {};
  const auto missed = slot - next_slot_;
  const bool slept = kSecond * missed > kLongestUnattended;
  waited_for_chamber_ = !slept && rig_.io().overtime() > Duration{};
  const auto* why = waited_for_chamber_ ? "the program waited for the chamber" : "the program was late";
  note(EventKind::fault, fmt::format("{} s without a tick: {}", missed, why));
  const bool goes_on = lead_->can_continue_alone() && run_state() != RunState::aborting;
  for (auto left = goes_on ? missed : 0; left > 0; --left)
    state_ = next(profile_, state_, {.elapsed = kSecond, .air = slept ? demanded_set_point(profile_, state_) : air_});
  tally_.count_gap(next_slot_, slot - 1);
  return store_.append_gap(std::exchange(next_slot_, slot), slot - 1, why);
}

void RunController::note_all(std::vector<RigChange> changes) {
  for (auto& change : changes) note(change.kind, std::move(change.text), std::move(change.about));
}

void RunController::note_changes(const Sample& sample) {
  note_all(
      changes_.compare_readings(sample, dropped_.all(), unit_may_be_off(profile_, state_) || power_.may_be_silent()));
  tally_.faulty_readings += changes_.faulty_readings();
  tally_.readings_while_off += changes_.readings_while_off();
  if (sample.progress.segment != last_segment_) note(EventKind::segment, describe(profile_, sample.progress));
  last_segment_ = sample.progress.segment;
}

LeadSecond RunController::second(const Sample& sample, Duration missed) const {
  return {.sample = sample,
          .goal = demanded_set_point(profile_, state_),
          .at = kSecond * (next_slot_ + 1),
          .missed = missed,
          .in_last_segment = sample.progress.segment + 1 >= static_cast<int>(profile_.segments.size()),
          .in_last_hold = sample.progress.segment + 1 >= static_cast<int>(profile_.segments.size()) &&
                          profile_.segments.back().kind == profile::SegmentKind::hold,
          .changed_by_another = is_changed_externally(memory_),
          .end = profile_.segments.back().target,
          .air_before = air_};
}

interlocks::InterlockInputs RunController::inputs(const Sample& sample, Duration missed) const {
  interlocks::InterlockInputs facts;
  facts.led_by_controller = !may_command(run_state()) || run_state() == RunState::aborting;
  lead_->fill_inputs(second(sample, missed), facts);
  facts.missed = missed;
  facts.longest_missed = kLongestUnattended;
  const auto health = store_.health();
  facts.backlog = std::chrono::seconds(health.backlog_s);
  facts.rows_dropped = health.rows_dropped;
  facts.storage_trouble = health.trouble;
  facts.record_damage = health.damage;
  facts.guard_troubles = guard_troubles_;
  facts.mismatched_instruments = rig_.io().mismatched_instruments();
  facts.gyro_is_off = unit_may_be_off(profile_, state_) || power_.may_be_silent();
  facts.power = power_.faults();
  facts.units_are_moved = run_state() == RunState::held;
  facts.door_may_open = run_state() == RunState::held || run_state() == RunState::aborting;
  facts.is_turned = profile_.segments[static_cast<std::size_t>(profile_position(profile_, state_).segment)].unit.turned;
  facts.dropped = dropped_.all();
  return facts;
}

interlocks::InterlockDemand RunController::judge_second(const Sample& sample, Duration missed) {
  auto result = judge(rig_.file().limits, std::move(memory_), sample, kSecond + missed, inputs(sample, missed));
  memory_ = std::move(result.memory);
  note_all(changes_.compare_alarms(result, sample, waited_for_chamber_ ? Duration{} : missed));
  return lead_->adjust_demand(std::move(result.demand), second(sample, missed));
}

void RunController::change_to(RunStateMachine machine) {
  const auto before = run_state();
  const auto after = run::run_state(machine);
  ensure(may_follow(before, after), "a run's states change along their table");
  const bool is_reported =
      before != after || (std::holds_alternative<Returning>(machine) && !std::holds_alternative<Returning>(machine_)) ||
      (after == RunState::held && state_cause(machine) != state_cause(machine_));
  const auto* returning = std::get_if<Returning>(&machine_);
  const auto why = returning != nullptr ? returning->cause : state_cause(machine_);
  machine_ = std::move(machine);
  if (!is_reported) return;
  const bool again = after == RunState::execute;
  note(EventKind::state,
       again && !why.empty() ? fmt::format("{}, after: {}", kProfileContinues, why) : describe(machine_));
}

/// Returns the task for the operator before the profile continues. A virtual rig confirms it immediately.
std::string RunController::required_prompt(const Sample& sample) {
  const auto& [segment, cycle, phase, in_segment, soaked, set_point] = sample.progress;
  if (in_segment != Duration{} || segment == answered_ || phase == Phase::complete) return {};
  const auto& prompt = profile_.segments[static_cast<std::size_t>(segment)].prompt;
  if (prompt.empty()) return {};
  auto asked = "the profile asks: " + prompt;
  if (!rig_.file().simulated) return asked;
  answered_ = segment;
  note(EventKind::note, asked + "; done by the virtual rig");
  return {};
}

/// Evaluates the reading of a chamber that is being made safe. Raises or clears the alarm safe_ineffective.
void RunController::update_safe_sequence(const Sample& sample) {
  const bool before = safe_.is_ineffective();
  safe_.add_reading(sample.chamber, kSecond * (next_slot_ + 1));
  if (safe_.is_ineffective() == before) return;
  const auto text = fmt::format("{} (abort): {}", kSafeIneffective, safe_.describe());
  note(before ? EventKind::recovered : EventKind::interlock,
       before ? fmt::format("{} is over: {}", kSafeIneffective, safe_.describe()) : text,
       {.interlock = kSafeIneffective,
        .reaction = name(before ? interlocks::Reaction::go_on : interlocks::Reaction::abort)});
}

void RunController::step_machine(const Sample& sample, const interlocks::InterlockDemand& demand, Duration missed) {
  demand_ = demand;
  auto request = take_request();
  if (const auto why = request ? active_refusal_reason(request->command, request->takes_over) : ""; !why.empty()) {
    note(EventKind::note, fmt::format("{} is not carried out: {}", name(request->command), why));
    request.reset();
  }
  const auto ended = causes_ended_by_resume(memory_);
  const bool takes_over = request && request->takes_over && !ended.empty();
  const auto of_power = std::ranges::count_if(ended, interlocks::is_about_power);
  if (takes_over && (of_power == 0 || of_power < std::ssize(ended))) lead_->allow_takeover();
  if (takes_over && of_power > 0) power_.switch_again(rig_.io());
  const bool leaves = request && request->command == OperatorCommand::stop && run_state() != RunState::aborting &&
                      demand.reaction < interlocks::Reaction::abort &&
                      rig_.file().run_limits.on_stop == interlocks::OnStop::hold;
  auto now_demanded = demand;
  if (auto why = leaves ? leaving_refusal(sample) : std::string(); !why.empty()) {
    note_following(why);
    now_demanded = {interlocks::Reaction::abort, std::move(why)};
  }
  const bool may_be_left = leaves && now_demanded.reaction < interlocks::Reaction::abort;
  const auto left = may_be_left ? lead_->send_last_set_point(rig_.io(), second(sample, missed)) : Result<void>();
  if (!left)
    note(EventKind::fault, "the chamber cannot be left at its set point, and is made safe: " + text(left.error()));
  if (run_state() == RunState::aborting) update_safe_sequence(sample);
  const RunInputs now{.elapsed = kSecond + missed,
                      .demand = std::move(now_demanded),
                      .request = std::move(request),
                      .prompt = required_prompt(sample),
                      .wait = power_.wait(),
                      .in_place = lead_->is_in_place(second(sample, missed)),
                      .safe_confirmed = safe_.is_confirmed() && power_.is_settled(),
                      .complete = false,
                      .takes_over = takes_over,
                      .may_be_left = left.has_value()};
  auto machine = next(rig_.file().run_limits, machine_, now);
  const auto* held = std::get_if<Held>(&machine);
  if (held && !now.prompt.empty() && held->cause == now.prompt) answered_ = sample.progress.segment;
  change_to(std::move(machine));
  if (run_state() == RunState::execute) lead_->end_approach();
  if (run_state() == RunState::aborting) power_.stop(rig_.io());
}

/// Returns the reading of the current segment's soak sensor, corrected by its certificate.
profile::Observation RunController::observation(const Sample& sample) const {
  const auto& sensor = soak_sensor(profile_, state_);
  profile::Observation seen{.elapsed = kSecond, .air = {}, .slope = {}};
  if (sensor == "air") {
    if (sample.chamber.value && !memory_.liveness.air.frozen) seen.air = sample.chamber.value->air;
    seen.slope = memory_.air.rate();
    return seen;
  }
  if (sensor == profile::kColdestThermometer) {
    if (const auto coldest = find_coldest(rig_.file().limits, sample))
      seen.air = record::calibrated(channels_[coldest->column], coldest->value);
    return seen;
  }
  const auto found = std::ranges::find(channels_, sensor, &record::Channel::name);
  const auto column = static_cast<std::size_t>(found - channels_.begin());
  if (column >= sample.thermometers.size()) return seen;
  if (const auto& reading = sample.thermometers[column].value) seen.air = record::calibrated(*found, *reading);
  seen.slope = memory_.thermometers[column].rate();
  return seen;
}

/// Records the end of a soak and its reason.
void RunController::note_soak(const ProfilePosition& before) {
  const auto& segment = profile_.segments[static_cast<std::size_t>(before.segment)];
  if (!segment.guaranteed_soak) return;
  const auto now = profile_position(profile_, state_);
  if (segment.is_warm_up) return;
  const auto what =
      fmt::format("±{:g} K of {:g} °C on {}", segment.soak_band.value, segment.target.value, segment.soak_sensor);
  if (now.phase == Phase::overdue && before.phase != Phase::overdue)
    return note(EventKind::note,
                fmt::format("soak of segment {} incomplete at its deadline: {} of {} inside {}", before.segment + 1,
                            format_duration(now.soaked), format_duration(segment.soak_time), what),
                {.segment = before.segment});
  if (now.segment == before.segment && now.phase != Phase::complete) return;
  note(EventKind::note,
       fmt::format("soak of segment {} ended: {} inside {}, in {}", before.segment + 1,
                   format_duration(segment.soak_time), what, format_duration(before.in_segment + kSecond)),
       {.segment = before.segment});
}

void RunController::step_profile(const Sample& sample) {
  const bool is_paused = run_state() != RunState::execute;
  const auto before = state_;
  state_ = is_paused ? next_while_paused(profile_, state_, observation(sample))
                     : next(profile_, state_, observation(sample));
  if (is_paused) return;
  if (std::holds_alternative<profile::Complete>(state_) && must_observe_end(sample)) {
    state_ = before;
    return;
  }
  note_prolonged_hold(sample.progress);
  note_soak(sample.progress);
  if (!std::holds_alternative<profile::Complete>(state_)) return;
  if (auto why = leaving_refusal(sample); !why.empty()) {
    note_following(why);
    return change_to(Aborting{std::move(why), {}, false});
  }
  if (auto why = lead_->incomplete_reason(second(sample, {})); !why.empty()) return change_to(Aborting{why, {}, false});
  change_to(next(rig_.file().run_limits, machine_,
                 RunInputs{.elapsed = {}, .demand = {}, .request = {}, .prompt = {}, .complete = true}));
  note(EventKind::finished, "profile complete");
}

/// Returns whether the profile's last second continues, because the chamber does not answer, or because the air of a
/// real chamber has been observed for too short a time to leave the chamber. Records the first second of the latter
/// kind.
bool RunController::must_observe_end(const Sample& sample) {
  const auto& rig = rig_.file();
  if (lead_->can_continue_alone()) return false;
  if (!sample.chamber.value) return true;  // its silence has an interlock
  if (rig.simulated) return false;
  const auto needed = std::min(rig.safe_observe, kLongestEndObservation);
  if (memory_.explained.watched >= needed) return false;
  if (!std::exchange(is_end_observed_, true))
    note(EventKind::note, fmt::format("the profile's last second continues until the air has been observed for {}",
                                      format_duration(needed)));
  return true;
}

/// Returns the reason why the chamber must not be left at its set point; empty if it may be left.
std::string RunController::leaving_refusal(const Sample& sample) const {
  if (lead_->can_continue_alone()) return {};
  return interlocks::leaving_refusal(rig_.file().limits, memory_, sample);
}

/// Raises the alarm of a chamber that must not be left at its set point.
void RunController::note_following(const std::string& why) {
  const auto* id = interlocks::name(interlocks::InterlockId::following);
  note(EventKind::interlock, fmt::format("{} (abort): {}", id, why),
       {.interlock = id, .reaction = name(interlocks::Reaction::abort)});
}

/// Records once that the clock of the last hold has stopped because no decision has been made.
void RunController::note_prolonged_hold(const ProfilePosition& before) {
  const auto now = profile_position(profile_, state_);
  const bool has_stopped =
      now.segment == before.segment && now.in_segment == before.in_segment && now.phase != Phase::overdue;
  if (!is_open(profile_) || !has_stopped || std::exchange(is_prolonged_, true)) return;
  note(EventKind::note, "the hold continues until the next block has been chosen");
}

bool RunController::awaits_decision() const {
  if (!is_open(profile_) || run_state() >= RunState::aborting) return false;
  const auto last = static_cast<int>(profile_.segments.size()) - 1;
  return profile_position(profile_, state_).segment == last && time_left(profile_, state_) <= kDecisionTime;
}

Result<void> RunController::carry_out(const record::Decision& decision) {
  const auto first = static_cast<int>(profile_.segments.size());
  auto grown = profile_;
  const auto added = add_block(grown, decision.block);
  if (!added) return failure(added.error());
  std::vector<record::RunInfo::SegmentInfo> segments;
  for (const auto& segment : *added) segments.push_back(describe_segment(segment));
  const auto event = record::decision_event(decision, rig_.clock().now(), first);
  if (auto stored = store_.append_decision(event, segments); !stored) return stored;
  profile_ = std::move(grown);
  planned_ = profile::total_time(profile_.segments);
  is_prolonged_ = false;
  return {};
}

/// Commands the chamber for the state after this second. The final set point is therefore sent in the profile's last
/// second.
void RunController::command_chamber(const Sample& sample) {
  if (run_state() < RunState::aborting)
    power_.require(rig_.io(),
                   profile_.segments[static_cast<std::size_t>(profile_position(profile_, state_).segment)].unit.off);
  rig_.set_unit_state(profile_.segments[static_cast<std::size_t>(sample.progress.segment)].unit);
  const auto failed = run_state() == RunState::aborting
                          ? safe_.attempt(rig_.io(), kSecond * next_slot_)
                          : lead_->send_set_point(rig_.io(), second(sample, {}), sample.state,
                                                  std::holds_alternative<Returning>(machine_), memory_);
  if (failed) note(EventKind::fault, *failed);
  if (run_state() != RunState::aborting) return;
  if (auto changed = relay_.advance(safe_.relay_due(), kSecond * next_slot_)) note(EventKind::fault, *changed);
}

void RunController::hand_over_to_controller() {
  lead_ = std::make_unique<ControllerLead>(set_point_tolerance(rig_.file().chamber_map));
}

std::string RunController::describe_cold_unit() const {
  return interlocks::describe_cold_unit(rig_.file().limits, last_);
}

std::string RunController::describe_external_change() const {
  for (const auto id : {interlocks::InterlockId::foreign_set_point, interlocks::InterlockId::not_following})
    if (memory_.is_cause_present(id)) return memory_.most_affected_watch(id).text;
  return {};
}

RunOverview RunController::overview() const {
  const auto left = time_left(profile_, state_);
  const bool is_ending = run_state() == RunState::aborting || run_state() == RunState::aborted;
  auto faults = active_faults(memory_);
  if (run_state() == RunState::aborting && safe_.is_failing()) faults.push_back(safe_.describe());
  if (!relay_.words().empty()) faults.push_back(relay_.words());
  return {.state = run_state(),
          .cause = state_cause(machine_),
          .stopped_by_operator = is_stopped_by_operator(machine_),
          .time_left = is_open(profile_) || is_ending ? std::nullopt : std::optional(left),
          .behind_plan = std::max(Duration{}, kSecond * next_slot_ - (planned_ - left)),
          .missed_set_points = lead_->missed_set_points(),
          .unconfirmed_set_points = lead_->unconfirmed_set_points(),
          .faults_now = std::move(faults)};
}

std::string RunController::end_cause() const {
  const auto cause = state_cause(machine_);
  const bool safe = run_state() == RunState::aborting || run_state() == RunState::aborted || safe_.is_confirmed();
  auto text = safe ? cause + "; " + safe_.describe() : cause;
  for (const auto& part : {relay_.words(), power_.describe_stop()})
    if (!part.empty()) text += "; " + part;
  return text;
}

std::vector<Event> RunController::take_pending_events() { return std::exchange(events_, {}); }

void RunController::make_safe(const std::string& cause) {
  if (!is_over(machine_) && run_state() != RunState::aborting) change_to(Aborting{cause, {}, false});
  if (run_state() == RunState::aborting) power_.stop(rig_.io());
  for (int i = 0; i < kSafeTries && !(safe_.is_confirmed() && power_.is_settled()); ++i) {
    (void)safe_.attempt(rig_.io(), kSecond * next_slot_);
    safe_.add_reading(read_rig(next_slot_, {}).chamber, kSecond * next_slot_);
  }
  note(EventKind::interlock, end_cause());
}

Sample RunController::read_rig(std::int64_t slot, Duration missed) {
  if (!std::exchange(has_power_begun_, true)) power_.begin(rig_.io(), profile_, state_);
  auto sample = rig_.io().read(slot, rig_.clock());
  auto report = power_.observe(rig_.io(), kSecond + missed);
  for (auto& text : report.notes) note(EventKind::note, std::move(text));
  for (auto& text : report.faults) note(EventKind::fault, std::move(text));
  return sample;
}

Result<RunOutcome> RunController::tick(std::int64_t slot) {
  const auto missed = kSecond * (slot - next_slot_);
  if (auto recorded = record_gap(slot); !recorded) return failure(recorded.error());
  auto sample = read_rig(slot, missed);
  dropped_.clear_readings(sample);
  sample.progress = profile_position(profile_, state_);
  note_changes(sample);
  const auto demand = judge_second(sample, missed);
  mask_dead_readings(rig_.file().limits, memory_.liveness, sample);
  step_machine(sample, demand, missed);
  sample.state = run_state();
  tally_.count_state(sample.state);
  if (sample.chamber.value && !memory_.liveness.air.frozen) air_ = sample.chamber.value->air;
  step_profile(sample);
  command_chamber(sample);
  if (sample.chamber.value && memory_.liveness.air.frozen)
    sample.chamber.value = failure(FaultKind::out_of_range, "", "its air is frozen");
  if (run_state() == RunState::aborted) note(EventKind::interlock, end_cause());
  if (is_over(machine_))
    if (auto cold = interlocks::describe_cold_unit(rig_.file().limits, sample); !cold.empty())
      note(EventKind::note, std::move(cold));

  note_ended_shelvings();
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

}  // namespace gyrotherm::run
