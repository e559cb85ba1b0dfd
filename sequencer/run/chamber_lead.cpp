// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/chamber_lead.hpp"

#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/process.hpp"
#include "drivers/chamber/register_map.hpp"
#include "sequencer/rig/inquiry.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/run/resume.hpp"
#include "sequencer/run/run_state_machine.hpp"

namespace gyrotherm::run {

namespace {

using interlocks::InterlockId;

bool was_restarted(const interlocks::InterlockMemory& memory) {
  return memory.is_active(InterlockId::restarted) || memory.is_active(InterlockId::restarted_off);
}

/// Returns true if a restarted chamber returns to the profile without an operator, and false if the restart holds the
/// run.
bool returns_without_operator(const interlocks::InterlockMemory& memory) {
  const auto acts_by_itself = [&](InterlockId id) {
    return memory.is_active(id) && memory.most_affected_watch(id).reaction < interlocks::Reaction::hold;
  };
  return acts_by_itself(InterlockId::restarted) || acts_by_itself(InterlockId::restarted_off);
}

/// Interval of attempts, in seconds, while the chamber refuses set points.
constexpr std::int64_t kTakeOverInterval = 10;
/// Air within this distance of a limit has reached the limit.
constexpr Kelvins kLimitTolerance{0.5};

}  // namespace

HostLead::HostLead(const rig::RigFile& rig, Celsius here, Duration at)
    : limits_(rig.chamber_limits),
      path_(rig.chamber_limits, set_point_tolerance(rig.chamber_map), rig.chamber_map.limits.every, here, at) {}

void HostLead::begin_away(std::optional<Celsius> air_before) {
  approaching_ = true;
  air_before_ = air_before;
}

void HostLead::fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) {
  if (const auto& chamber = second.sample.chamber.value) inputs.sent = path_.expected(chamber->set_point);
  inputs.set_point_tolerance = path_.tolerance();
  inputs.refusals = path_.refusals();
  inputs.refusal = path_.refusal();
  inputs.sends_again = path_.sends_again(second.at - kSecond - second.missed);
}

interlocks::InterlockDemand HostLead::adjust_demand(interlocks::InterlockDemand demand, const LeadSecond& second) {
  const auto& chamber = second.sample.chamber.value;
  const auto& before = second.air_before;
  unread_time_ += second.missed;
  if (!chamber) return demand;
  const auto missed = std::exchange(unread_time_, Duration{});
  if (missed <= Duration{} || !before) return demand;
  if (abs(chamber->air - second.goal) <= abs(*before - second.goal) + kResumeBand) return demand;
  approaching_ = true;  // also if another cause stops it
  if (demand.reaction >= interlocks::Reaction::suspend) return demand;
  return {interlocks::Reaction::suspend,
          fmt::format("the air is at {:.2f} °C, before {} without a tick it was at {:.2f} °C", chamber->air.value,
                      format_duration(missed), before->value)};
}

bool HostLead::is_in_place(const LeadSecond& second) const {
  if (!path_.is_at(second.goal)) return false;
  if (!approaching_) return true;
  const auto& chamber = second.sample.chamber.value;
  return chamber && gyrotherm::run::is_in_place(chamber->air, second.goal, air_before_);
}

void HostLead::end_approach() {
  approaching_ = false;
  air_before_.reset();
}

/// Takes control of the chamber at its current air temperature: sends that set point, then switches the chamber on.
std::optional<std::string> HostLead::take_over_chamber(io::InstrumentIo& io, const LeadSecond& second) {
  const auto& chamber = *second.sample.chamber.value;
  approaching_ = true;
  if (!std::isnan(chamber.set_point.value)) path_.accept_as_sent(chamber.set_point);
  path_.begin_at(chamber.air);
  const auto taken =
      path_.advance(io, clamp_to_limits(chamber.air, limits_), second.at).and_then([&] { return io.switch_on(true); });
  return taken ? std::nullopt : std::optional("taking the chamber over: " + text(taken.error()));
}

Result<void> HostLead::send_last_set_point(io::InstrumentIo&, const LeadSecond& second) {
  if (second.changed_by_another)
    return failure(FaultKind::refused, "chamber",
                   "another program or its panel changed its set point; it does not follow the profile");
  return {};
}

/// Returns true if the air is outside the limits, the set point is the nearest limit, and the air has not arrived
/// there.
bool HostLead::is_waiting_for_air(Celsius air) const {
  const auto nearest = clamp_to_limits(air, limits_);
  return approaching_ && path_.is_at(nearest) && abs(air - nearest) > kLimitTolerance;
}

bool is_changed_externally(const interlocks::InterlockMemory& memory) {
  return memory.is_cause_present(interlocks::InterlockId::foreign_set_point) ||
         memory.is_cause_present(interlocks::InterlockId::not_following);
}

std::optional<std::string> HostLead::send_set_point(io::InstrumentIo& io, const LeadSecond& second, RunState state,
                                                    bool returning, const interlocks::InterlockMemory& memory) {
  if (!may_command(state) || !second.sample.chamber.value) return std::nullopt;
  if (std::exchange(taking_over_, false) || returns_without_operator(memory)) return take_over_chamber(io, second);
  if (was_restarted(memory)) return std::nullopt;  // an operator decides
  if (memory.is_active(interlocks::InterlockId::not_taken))
    return second.sample.slot % kTakeOverInterval == 0 ? take_over_chamber(io, second) : std::nullopt;
  if (is_changed_externally(memory)) {
    approaching_ = approaching_ || memory.is_active(interlocks::InterlockId::foreign_set_point) ||
                   memory.is_active(interlocks::InterlockId::not_following);
    // An unexplained set point is not overwritten, even before its alarm is raised.
    return std::nullopt;
  }
  if (state != RunState::execute && !returning) return std::nullopt;
  if (is_waiting_for_air(second.sample.chamber.value->air)) return std::nullopt;
  ensure(may_command(state), "a set point is sent only while the run is carried out");
  const auto sent = path_.advance(io, second.goal, second.at);
  return sent || path_.refusals() != 1 ? std::nullopt
                                       : std::optional(text(rig::name_instrument(rig::kChamberTitle, sent.error())));
}

namespace {

/// Time without the program after which it has ended for good. Longer than the age of any status, and than the advance
/// of the controller's clock.
constexpr Duration kProgramGoneTime = std::chrono::seconds(60);
/// Attempts to stop the program. One lost exchange must not leave it running.
constexpr int kStopTries = 3;

/// Returns true if a controller may be carrying out a program. A program held at the panel makes no progress. An
/// unknown activity counts as progress.
bool may_progress(ChamberActivity activity) {
  if (activity == ChamberActivity::holding) return false;
  return activity == ChamberActivity::unknown || is_program_activity(activity);
}

std::string to_capitals(const std::string& name) {
  std::string all;
  for (const unsigned char c : name)
    if (std::isalnum(c) != 0) all += static_cast<char>(std::toupper(c));
  return all.empty() ? "PROFILE" : all;
}

/// Returns the reason why a controller cannot carry out a segment that begins at `from`; empty if it can. A
/// controller's guaranteed soak uses the air sensor of the chamber and counts the total time in the band.
std::string controller_refusal(const profile::Segment& segment, Celsius from) {
  if (!segment.prompt.empty()) return "a controller cannot wait for an operator, and this segment has a prompt";
  if (segment.unit.off) return "a controller cannot switch the units, and this segment requires them to be off";
  if (segment.kind == profile::SegmentKind::hold && segment.target != from)
    return fmt::format("a controller jumps from {:g} °C to {:g} °C, expected a ramp before this hold", from.value,
                       segment.target.value);
  if (!segment.guaranteed_soak || segment.is_warm_up) return {};
  if (segment.soak_sensor != "air")
    return fmt::format("a controller soaks on its own air sensor, but soak_sensor is \"{}\"", segment.soak_sensor);
  if (segment.soak_slope > CelsiusPerMinute{0})
    return fmt::format("a controller does not wait for steady air, but soak_slope is {:g} °C/min",
                       segment.soak_slope.value);
  if (segment.soak_dwell > Duration{})
    return fmt::format("a controller counts from the first second in the band, but soak_dwell is {:g} s",
                       to_seconds(segment.soak_dwell));
  if (segment.soak_time < segment.duration)
    return fmt::format("a controller requires the whole hold inside the band, but soak_time is {:g} s of {:g} s",
                       to_seconds(segment.soak_time), to_seconds(segment.duration));
  return {};
}

}  // namespace

Result<drivers::ChamberProgram> make_chamber_program(const profile::Profile& profile) {
  drivers::ChamberProgram program{.name = to_capitals(profile.name), .number = 1, .soak_band = {}, .steps = {}};
  std::optional<Kelvins> band;
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    if (auto why = controller_refusal(segment, set_point_before(profile, i)); !why.empty())
      return failure(FaultKind::usage, segment.place, std::move(why));
    drivers::ProgramStep step{
        .kind = segment.kind == profile::SegmentKind::ramp ? drivers::StepKind::ramp : drivers::StepKind::soak,
        .start = segment.kind == profile::SegmentKind::ramp ? set_point_before(profile, i) : segment.target,
        .target = segment.target,
        .duration = shortest(segment),
        .guaranteed_soak = segment.guaranteed_soak && !segment.is_warm_up};
    if (step.guaranteed_soak && band && *band != segment.soak_band)
      return failure(FaultKind::usage, segment.place, "a controller has one soak band for the whole profile");
    if (step.guaranteed_soak) band = segment.soak_band;
    if (step.duration > Duration{}) program.steps.push_back(step);
  }
  program.soak_band = band.value_or(Kelvins{});
  return program;
}

std::string ControllerLead::refusal_reason(OperatorCommand command) const {
  if (command != OperatorCommand::pause) return {};
  return "the controller runs the profile; only its panel can pause it";
}

namespace {

/// Returns true if the controller keeps the air at a set point after the end of its program.
bool has_finished(ChamberActivity activity) {
  return activity == ChamberActivity::running || activity == ChamberActivity::done;
}

/// Returns how long a condition has lasted after one more second. A time without ticks counts only if the condition was
/// present before it and the machine did not sleep.
Duration prolonged(Duration lasted, const LeadSecond& second) {
  const bool counts = lasted > Duration{} && second.missed <= kLongestUnattended;
  return lasted + kSecond + (counts ? second.missed : Duration{});
}

}  // namespace

/// Returns true if the controller may have ended its program in the profile's last segment. After a hold, its air then
/// stays at the hold's set point; after a ramp, it shows the final set point.
bool ControllerLead::may_have_finished(const LeadSecond& second) const {
  const auto& chamber = *second.sample.chamber.value;
  if (!second.in_last_segment || !has_finished(chamber.activity)) return false;
  return second.in_last_hold ? !away_ : !(abs(chamber.set_point - second.end) > tolerance_);
}

std::string ControllerLead::incomplete_reason(const LeadSecond& second) const {
  const auto& chamber = second.sample.chamber.value;
  if (silent_ >= kProgramGoneTime)
    return "at the end of its program the chamber has been silent for " + format_duration(silent_);
  if (!chamber) return {};
  const auto activity = chamber->activity;
  if (!may_progress(activity) && !has_finished(activity) && activity != ChamberActivity::off)
    return fmt::format("at the end of its program the controller does not run it: {}", name(activity));
  if (away_)
    return fmt::format("at the end of its program the air moves away from {:g} °C: {:.2f} °C", second.end.value,
                       chamber->air.value);
  return {};
}

/// Watches the air in a hold at the profile's end. The air must approach the set point, or stay there.
void ControllerLead::watch_end(const LeadSecond& second) {
  const auto& chamber = second.sample.chamber.value;
  silent_ = chamber ? Duration{} : prolonged(silent_, second);
  if (!chamber || !second.in_last_hold) return;
  if (!end_watch_) end_watch_.emplace(second.end, Duration::max());
  away_ = end_watch_->add_reading(chamber->air, second.at) == watchdog::AirVerdict::moves_away;
}

std::string ControllerLead::judge(const LeadSecond& second) {
  const auto& chamber = second.sample.chamber.value;
  if (!chamber) return {};
  const bool progresses = may_progress(chamber->activity) || may_have_finished(second);
  gone_ = progresses ? Duration{} : prolonged(gone_, second);
  if (gone_ < kProgramGoneTime) return {};
  return fmt::format("the controller has not run its program for {}: {}", format_duration(gone_),
                     name(chamber->activity));
}

void ControllerLead::fill_inputs(const LeadSecond& second, interlocks::InterlockInputs& inputs) {
  inputs.led_by_controller = true;
  watch_end(second);
  inputs.program = judge(second);
}

interlocks::InterlockDemand ControllerLead::adjust_demand(interlocks::InterlockDemand demand, const LeadSecond&) {
  return demand.reaction < interlocks::Reaction::abort ? interlocks::InterlockDemand{} : demand;
}

Result<void> ControllerLead::send_last_set_point(io::InstrumentIo& io, const LeadSecond& second) {
  auto left = io.send_set_point_immediately(second.goal);
  for (int tries = 1; !left && tries < kStopTries; ++tries) left = io.send_set_point_immediately(second.goal);
  return left;
}

}  // namespace gyrotherm::run
