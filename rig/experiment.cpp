#include "rig/experiment.hpp"

#include <fmt/format.h>

#include <utility>

namespace gyrotherm {
namespace {

constexpr Duration kTick = std::chrono::seconds(1);
constexpr int kSafeTries = 3;
constexpr std::size_t kChamber = 0;  ///< its place among the columns

/// The fault of each column, or null: chamber, thermometers, gyro.
std::vector<const Fault*> faults_of(const Sample& sample) {
  const auto of = [](const auto& reading) { return reading.value ? nullptr : &reading.value.error(); };
  std::vector<const Fault*> faults{of(sample.chamber)};
  for (const auto& reading : sample.thermometers) faults.push_back(of(reading));
  faults.push_back(of(sample.gyro));
  return faults;
}

std::string describe(const Profile& profile, const Progress& progress) {
  if (progress.phase == Phase::complete) return "profile complete";
  const auto& segment = profile.segments[static_cast<std::size_t>(progress.segment)];
  return fmt::format("segment {} of {}: {}", progress.segment + 1, profile.segments.size(), segment.name);
}

}  // namespace

Experiment::Experiment(const Profile& profile, Rig& rig, Store& store, State state, std::int64_t first_slot)
    : profile_(profile),
      rig_(rig),
      store_(store),
      state_(std::move(state)),
      next_slot_(first_slot),
      acknowledged_(command(profile, state_)) {}

void Experiment::note(EventKind kind, std::string text) {
  events_.push_back({rig_.clock().now(), kind, std::move(text)});
}

Result<void> Experiment::record_gap(std::int64_t slot) {
  if (slot <= next_slot_) return {};
  const auto missed = slot - next_slot_;
  note(EventKind::fault, fmt::format("{} s without a tick: the program was late", missed));
  return store_.append_gap(next_slot_, slot - 1, "the program was late");
}

/// The profile's clock runs through slots that had no tick.
void Experiment::catch_up(std::int64_t slot) {
  if (slot > next_slot_ && reaction_ == Reaction::go_on)
    state_ = next(profile_, state_, {.elapsed = kTick * (slot - next_slot_), .air = air_});
  next_slot_ = slot;
}

void Experiment::note_changes(const Sample& sample) {
  const auto faults = faults_of(sample);
  faulty_.resize(faults.size());
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (faults[i] && !faulty_[i]) note(EventKind::fault, text(*faults[i]));
    if (!faults[i] && faulty_[i]) note(EventKind::recovered, fmt::format("column {} answers again", i));
    if (i == kChamber && !faults[i] && faulty_[i]) acknowledged_.reset();  // it may have been off: it is told again
    faulty_[i] = faults[i] != nullptr;
  }
  if (sample.chamber.value && sample.chamber.value->alarms != alarms_) {
    alarms_ = sample.chamber.value->alarms;
    note(alarms_.empty() ? EventKind::recovered : EventKind::fault,
         alarms_.empty() ? "chamber: no alarm any more" : fmt::format("chamber alarm: {}", fmt::join(alarms_, "; ")));
  }
  if (sample.progress.segment != last_segment_) note(EventKind::segment, describe(profile_, sample.progress));
  last_segment_ = sample.progress.segment;
}

void Experiment::send_set_point() {
  const auto target = command(profile_, state_);
  const auto every = rig_.file().chamber_map.limits.every;
  if (acknowledged_ == target || (last_sent_ && kTick * (next_slot_ - *last_sent_) < every)) return;
  last_sent_ = next_slot_;
  const auto sent = rig_.sampler().command(target);
  acknowledged_ = sent ? std::optional(target) : std::nullopt;
  if (!sent) note(EventKind::fault, text(sent.error()));
}

void Experiment::make_safe(const std::string& cause) {
  const auto safe = rig_.file().safe_set_point;
  Result<void> sent;
  for (int i = 0; i < kSafeTries; ++i)
    if (sent = rig_.sampler().command(safe); sent) break;
  end_cause_ =
      sent ? fmt::format("{}; the chamber was sent to {:g} °C", cause, safe.value)
           : fmt::format("{}; the chamber could NOT be sent to {:g} °C ({})", cause, safe.value, text(sent.error()));
  note(EventKind::interlock, end_cause_);
}

/// What a controller does by itself goes on while an instrument is silent.
void Experiment::judge_controller(const Sample& sample, Duration elapsed, Verdict& verdict) {
  if (!watch_) return;
  if (verdict.reaction == Reaction::suspend) verdict = {};
  const bool last = sample.progress.segment + 1 >= static_cast<int>(profile_.segments.size());
  const auto cause = watch_->judge(sample.chamber, last, elapsed);
  if (!cause.empty() && verdict.reaction != Reaction::abort) verdict = {Reaction::abort, cause};
}

Result<Outcome> Experiment::tick(std::int64_t slot) {
  const auto elapsed = kTick * (slot + 1 - next_slot_);
  if (auto recorded = record_gap(slot); !recorded) return failure(recorded.error());
  catch_up(slot);
  auto sample = rig_.sampler().read(slot, rig_.clock());
  sample.progress = progress_of(profile_, state_);
  if (sample.chamber.value) air_ = sample.chamber.value->air;
  note_changes(sample);

  auto judgement = judge(rig_.file().limits, memory_, sample, elapsed);
  memory_ = judgement.memory;
  judge_controller(sample, elapsed, judgement.verdict);
  if (judgement.verdict.reaction != std::exchange(reaction_, judgement.verdict.reaction))
    note(reaction_ == Reaction::go_on ? EventKind::recovered : EventKind::interlock,
         reaction_ == Reaction::go_on ? "the profile goes on" : judgement.verdict.cause);

  const auto air_now = sample.chamber.value ? air_ : std::nullopt;
  if (reaction_ == Reaction::go_on) state_ = next(profile_, state_, {.elapsed = kTick, .air = air_now});
  const bool complete = std::holds_alternative<Complete>(state_);
  if (reaction_ == Reaction::abort) make_safe(judgement.verdict.cause);
  if (reaction_ == Reaction::go_on && !complete && !watch_) send_set_point();
  if (complete) note(EventKind::finished, "profile complete");

  if (auto stored = store_.append(sample, events_); !stored) return failure(stored.error());
  events_.clear();
  last_ = std::move(sample);
  next_slot_ = slot + 1;
  if (reaction_ == Reaction::abort) return Outcome::made_safe;
  return complete ? Outcome::complete : Outcome::going_on;
}

}  // namespace gyrotherm
