// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/invariants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquisition/record/backlog.hpp"
#include "core/clock.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/run/resume.hpp"

namespace gyrotherm::faults {
namespace {

using Kind = InjectedFaultKind;

constexpr std::size_t kMostViolations = 20;
/// Longest time by which a set point may lag its ramp, s. It may catch up in one step.
constexpr double kSecondsToCatchUp = 10;
constexpr Kelvins kSame{0.02}, kNearAir{2.5};
/// Longest recovery, including the return to the profile by a ramp, s.
constexpr std::int64_t kRecoversWithin = 3600;
/// Largest number of attempts to send a set point that the chamber refused.
constexpr int kMaxTries = 3;
/// Longest time to the storage alarm, including the last batch before a sync is requested, s.
constexpr std::int64_t kUntilAlarm = 15;
constexpr std::int64_t kLinkSettles = 16;  ///< pause of a failed line: 10 s

double largest_step_k(const profile::ChamberLimits& limits, bool up) {
  const auto rate = up ? limits.fastest_heating : limits.fastest_cooling;
  return std::abs(rate.value) / 60 * kSecondsToCatchUp;
}

/// Returns true if `after` may follow `before`. This table is independent of the program's.
bool follows(RunState before, RunState after) {
  if (before == after) return true;
  switch (before) {
    case RunState::execute: return after != RunState::aborted;
    case RunState::suspended:
    case RunState::held: return after != RunState::aborted && after != RunState::complete;
    case RunState::aborting: return after == RunState::aborted || after == RunState::stopped;
    case RunState::aborted:
    case RunState::stopped:
    case RunState::complete: return false;
  }
  return false;
}

}  // namespace

int severity(RunState state) {
  switch (state) {
    case RunState::execute: return 0;
    case RunState::suspended: return 1;
    case RunState::held: return 2;
    case RunState::aborting:
    case RunState::aborted: return 3;
    case RunState::stopped:
    case RunState::complete: return 4;
  }
  return 0;
}

Invariants::Invariants(const profile::Profile& profile, const rig::RigFile& file, Plant& plant,
                       const FaultInjector& injector)
    : profile_(profile), file_(file), plant_(plant), injector_(injector) {
  const auto& names = plant.laboratory().thermometer_names();
  for (const auto& channel : file.limits.channels)
    places_.push_back(static_cast<std::size_t>(std::ranges::find(names, channel) - names.begin()));
  lowest_ = highest_ = file.safe_set_point;
  each_released(profile, [&](const profile::Segment& segment, Celsius) {
    lowest_ = std::min(lowest_, segment.target);
    highest_ = std::max(highest_, segment.target);
  });
  lowest_ = std::max(lowest_, file.chamber_limits.lowest);
  highest_ = std::min(highest_, file.chamber_limits.highest);
}

void Invariants::report_violation(const char* invariant, std::int64_t second, const std::string& what) {
  if (violations_.size() < kMostViolations)
    violations_.push_back(fmt::format("{} at second {}: {}", invariant, second, what));
}

std::int64_t Invariants::gap_seconds() const {
  std::int64_t sum = 0;
  for (const auto& gap : gaps_) sum += gap.last - gap.first + 1;
  return sum;
}

void Invariants::begin_life(std::int64_t last_recorded) {
  while (!rows_.empty() && rows_.back().slot > last_recorded) rows_.pop_back();
  std::erase_if(gaps_, [&](const auto& gap) { return gap.first > last_recorded; });
  last_slot_ = last_recorded;
  last_time_ = std::chrono::seconds(last_recorded);  // later rows are lost
  last_state_.reset();
  quiet_ticks_ = {};
  storage_alarm_ = false;
  lost_channels_.clear();
  restart_liveness();
}

bool Invariants::is_active(InjectedFaultKind first, InjectedFaultKind last) const {
  return std::ranges::any_of(injector_.active_faults(),
                             [&](const auto& fault) { return fault.kind >= first && fault.kind <= last; });
}

/// I1, I2, I3, I4: judges the set points that were sent. A return to the profile may begin at an air temperature
/// outside the profile's extremes, clamped to the limits, and must move towards the profile, also if the air sensor
/// then fails. If a broken chamber keeps the air away or shows the previous set point, a set point that was not read
/// back may be sent again.
void Invariants::judge_set_points(std::int64_t second, const Sample& sample) {
  const RunState state = sample.state;
  auto& port = plant_.chamber();
  const auto& limits = file_.chamber_limits;
  auto before = in_force_;
  sent_before_ = sent_;
  const bool is_broken =
      is_active(Kind::heater_weak, Kind::machinery_stuck) || is_active(Kind::air_sensor_error, Kind::air_sensor_frozen);
  is_kept_away_ = is_kept_away_ || is_broken;
  for (const auto& sent : port.set_points_sent()) {
    const auto value = sent.value;
    const auto air = plant_.laboratory().air_as_measured();
    const bool air_is_beyond = air < limits.lowest || air > limits.highest;
    const bool near_air = abs(value - air) <= kNearAir ||
                          (air_is_beyond && abs(value - std::clamp(air, limits.lowest, limits.highest)) <= kSame);
    const bool inwards = value < lowest_ ? value >= before : value <= before;
    const bool in_profile = value >= lowest_ - kSame && value <= highest_ + kSame;
    const bool in_chamber = value >= limits.lowest - kSame && value <= limits.highest + kSame;
    if (in_profile || near_air) is_kept_away_ = is_broken;
    if (!in_chamber || !(in_profile || near_air || (is_kept_away_ && inwards)))
      report_violation("I1", second,
                       fmt::format("set point {} outside {} … {}", value.value, lowest_.value, highest_.value));
    const bool safe = severity(state) >= severity(RunState::aborting) && abs(value - file_.safe_set_point) <= kSame;
    const double step_k = std::abs((value - before).value);
    tries_ = sent_ && abs(value - *sent_) <= kSame ? tries_ + 1 : 0;
    const bool tried_again = tries_ > 0 && tries_ <= kMaxTries;
    if (!safe && !near_air && !tried_again && step_k > largest_step_k(limits, value > before) + kSame.value)
      report_violation("I2", second, fmt::format("set point jumps from {} to {}", before.value, value.value));
    if (severity(state) > severity(RunState::aborting) || state == RunState::aborted)
      report_violation("I3", second, fmt::format("set point {} sent in state {}", value.value, name(state)));
    if (sent.before_read_back && !safe)
      report_violation("I4", second, fmt::format("set point {} sent before another one was read back", value.value));
    if (sent.applied) before = value;
    sent_ = value;
  }
  const bool is_unconfirmed = severity(state) >= severity(RunState::aborting) && !sample.chamber.value && sent_ &&
                              abs(*sent_ - file_.safe_set_point) <= kSame;
  if (port.unread_set_points() > 0 && !is_unconfirmed)
    report_violation("I4", second, "a set point was not read back by the next exchange");
  port.forget();
}

/// I10, I11, I12: each slot is in one row or one gap, in order.
void Invariants::judge_rows(std::int64_t second, const RecordingStore& recording) {
  for (const auto& gap : recording.gaps()) {
    if (gap.first != last_slot_ + 1)
      report_violation("I10", second, fmt::format("gap from {} after {}", gap.first, last_slot_));
    if (gap.cause.empty() || gap.last < gap.first)
      report_violation("I11", second, "a gap without cause or without slots");
    gaps_.push_back(gap);
    last_slot_ = gap.last;
  }
  if (!recording.sample()) return;
  const auto& sample = *recording.sample();
  if (sample.slot != last_slot_ + 1)
    report_violation("I10", second, fmt::format("slot {} after {}", sample.slot, last_slot_));
  if (sample.at.since_start <= last_time_) report_violation("I12", second, "time does not advance");
  last_slot_ = sample.slot;
  last_time_ = sample.at.since_start;
}

/// I13 and P9: a good stored value is the instrument's value in this second.
void Invariants::judge_values(std::int64_t second, const Sample& sample) {
  constexpr double kFloatK = 1e-5, kTextK = 5.1e-4;
  const auto& laboratory = plant_.laboratory();
  const auto same = [](double a, double b, double within) {
    return std::abs(a - b) <= within * (1 + std::abs(b) / 100);
  };
  if (const auto& chamber = sample.chamber.value) {
    if (!same(chamber->air.value, laboratory.air_as_measured().value, kFloatK))
      report_violation(
          "I13", second,
          fmt::format("air {} stored, the chamber showed {}", chamber->air.value, laboratory.air_as_measured().value));
    if (!same(chamber->set_point.value, in_force_.value, kFloatK))
      report_violation(
          "I13", second,
          fmt::format("set point {} stored, the chamber had {}", chamber->set_point.value, in_force_.value));
  }
  const auto shown = laboratory.thermometers_as_measured_c();
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    if (const auto& reading = sample.thermometers[i].value; reading && !same(reading->value, shown[places_[i]], kTextK))
      report_violation("I13", second,
                       fmt::format("thermometer {} stored as {}, it showed {}", i, reading->value, shown[places_[i]]));
  for (std::size_t line = 0; line < file_.gyro_lines.size(); ++line)
    for (const auto& share : file_.gyro_lines[line].shares) {
      const auto& count = sample.units[share.unit].count.value;
      if (!count || count->pulses.empty()) continue;
      if (count->interval <= Duration{} || !plant_.gyro(line).matches_sent_counts(*count, share.axes.front()))
        report_violation("I13", second,
                         fmt::format("gyro {} did not count {} in {} ns", share.unit, fmt::join(count->pulses, ", "),
                                     count->interval.count()));
    }
}

/// I28: another instrument receives no command, and its values are not stored as good. While a fault hides the answers
/// or their sender, an exchange cannot be seen, and the safe state is sent without an answer.
void Invariants::judge_identities(std::int64_t second, const Sample& sample) {
  const bool is_hidden = severity(sample.state) >= severity(RunState::aborting) && !sample.chamber.value &&
                         (is_active(Kind::chamber_silent, Kind::chamber_half_open) ||
                          is_active(Kind::chamber_answers_lost, Kind::chamber_cut) ||
                          is_active(Kind::chamber_foreign_unit, Kind::chamber_wrong_number));
  if (plant_.chamber().take_writes_to_other_chamber() > 0 && !is_hidden)
    report_violation("I28", second, "another chamber received a command");
  if (plant_.chamber().trouble.exchanged && sample.chamber.value)
    report_violation("I28", second, "a value of another chamber is stored as good");
  for (std::size_t i = 0; i < plant_.thermometer_count(); ++i) {
    if (!plant_.is_exchanged(i)) continue;
    const auto& places = plant_.places(i);
    for (std::size_t channel = 0; channel < sample.thermometers.size(); ++channel)
      if (std::ranges::count(places, places_[channel]) > 0 && sample.thermometers[channel].value)
        report_violation("I28", second, fmt::format("channel {} of another thermometer is stored as good", channel));
  }
}

bool Invariants::is_troubled(std::size_t line) const {
  return std::ranges::any_of(injector_.active_faults(), [&](const auto& fault) {
    const bool of_this_gyro = fault.kind >= Kind::gyro_silent && fault.kind <= Kind::gyro_restarts &&
                              static_cast<std::size_t>(fault.target) % plant_.gyro_count() == line;
    return of_this_gyro || fault.kind == Kind::machine_sleeps;
  });
}

/// I24: a unit with an undisturbed line is read regardless of faults of other units. A dropped unit has no values.
void Invariants::judge_units(std::int64_t second, const Sample& sample, const Operators& operators) {
  // Ticks after any change of the faults before a unit is checked again.
  constexpr std::int64_t kCountsAgainAfter = 5;
  untroubled_ticks_.resize(file_.gyro_lines.size());
  for (std::size_t line = 0; line < file_.gyro_lines.size(); ++line) {
    const bool is_new = injector_.last_change() >= second - 1;
    auto& ticks = untroubled_ticks_[line];
    ticks = is_troubled(line) || is_new || plant_.laboratory().unit().off ? 0 : ticks + 1;
    for (const auto& share : file_.gyro_lines[line].shares) {
      const auto& count = sample.units[share.unit].count.value;
      const auto& name = file_.units[share.unit].info.name;
      const bool is_out = operators.has_dropped(name);
      if (is_out && (!count || !count->pulses.empty()))
        report_violation("I24", second, fmt::format("gyro {} is dropped but still in the record", name));
      if (!is_out && ticks > kCountsAgainAfter && (!count || count->pulses.empty()))
        report_violation("I24", second,
                         fmt::format("gyro {} is lost although its line works: {}", name,
                                     count ? "nothing in it" : count.error().what));
    }
  }
}

/// I5, I6: states change along the table, and never back from an abort.
void Invariants::judge_state(std::int64_t second, const Sample& sample) {
  if (last_state_ && !follows(*last_state_, sample.state))
    report_violation("I5", second, fmt::format("state {} follows {}", name(sample.state), name(*last_state_)));
  last_state_ = sample.state;
  ++seconds_in_state_[static_cast<std::size_t>(sample.state)];
}

/// I7: a sleep of the machine holds the run. A disk that accepts nothing for longer than the rig file permits raises an
/// alarm.
void Invariants::judge_machine(std::int64_t second, const RecordingStore& recording, RunState state) {
  const auto seconds = [](Duration time) { return time / std::chrono::seconds(1); };
  for (const auto& gap : recording.gaps())
    if (gap.cause == "the program was late" && gap.last - gap.first + 1 > seconds(run::kLongestUnattended) &&
        severity(state) < severity(RunState::held))
      report_violation("I7", second,
                       fmt::format("after {} s without a tick in state {}", gap.last - gap.first + 1, name(state)));
  for (const auto& event : recording.events()) {
    if (event.about.interlock == name(interlocks::InterlockId::storage))
      storage_alarm_ = event.kind != EventKind::recovered;
  }
  const bool dead =
      is_active(Kind::disk_full, Kind::disk_fails) || is_active(Kind::disk_loses_syncs, Kind::disk_loses_syncs);
  quiet_ticks_.disk_dead = dead ? quiet_ticks_.disk_dead + 1 : 0;
  if (quiet_ticks_.disk_dead > seconds(file_.limits.backlog) + kUntilAlarm && !storage_alarm_)
    report_violation("I7", second,
                     fmt::format("no alarm although the disk accepts nothing for {} s", quiet_ticks_.disk_dead));
}

/// I21: a lost thermometer is reported by name immediately, and suspends the run if the analysis needs it.
void Invariants::judge_channels(std::int64_t second, const RecordingStore& recording, const Sample& sample,
                                const Operators& operators) {
  const auto suspend_after = file_.limits.suspend_after / std::chrono::seconds(1);
  lost_channels_.resize(sample.thermometers.size());
  for (std::size_t i = 0; i < lost_channels_.size(); ++i) {
    auto& lost = lost_channels_[i];
    const auto& name = file_.limits.channels[i];
    lost = sample.thermometers[i].value ? LostChannel{} : LostChannel{lost.ticks + 1, lost.reported};
    for (const auto& event : recording.events())
      lost.reported = lost.reported || (event.kind == EventKind::fault && event.about.channel == name) ||
                      event.about.interlock == interlocks::name(interlocks::InterlockId::frozen);
    if (lost.ticks > 1 && !lost.reported) report_violation("I21", second, fmt::format("loss of {} not reported", name));
    const bool is_needed = std::ranges::any_of(file_.limits.units, [&](const auto& unit) {
      return !operators.has_dropped(unit.name) && std::ranges::count(unit.thermometers, i) > 0;
    });
    if (is_needed && lost.ticks > suspend_after + 3 && severity(sample.state) < severity(RunState::suspended))
      report_violation("I21", second, fmt::format("{} is needed and lost, but the run continues", name));
  }
}

/// I18: no alarm is raised before the first fault.
void Invariants::judge_alarms(std::int64_t second, const RecordingStore& recording) {
  const auto finished = [](const Event& event) { return event.kind == EventKind::finished; };
  if (injector_.has_any_begun() || std::ranges::any_of(recording.events(), finished)) return;
  for (const auto& event : recording.events())
    if (event.kind == EventKind::fault || event.kind == EventKind::interlock || event.kind == EventKind::state)
      report_violation("I18", second, "alarm without a cause: " + event.text);
}

/// I14: judges a segment at its end. Seconds without a row are not soak time.
void Invariants::judge_segment_end(std::int64_t second, int index) {
  const auto& segment = profile_.segments[static_cast<std::size_t>(index)];
  std::int64_t clock = 0, soaked = 0, first = -1, last = -1;
  for (auto row = rows_.rbegin(); row != rows_.rend() && row->segment >= index; ++row) {
    if (row->segment != index) continue;
    if (last < 0) last = row->slot;
    first = row->slot;
    clock += row->state == RunState::execute ? 1 : 0;
    soaked += row->state == RunState::execute && row->in_band ? 1 : 0;
  }
  std::int64_t unseen = 0;
  for (const auto& gap : gaps_)
    if (gap.last >= first - 1 && gap.first <= last + 1) unseen += gap.last - gap.first + 1;
  const auto seconds = [](Duration time) { return time / std::chrono::seconds(1); };
  if (first >= 0 && clock + unseen < seconds(segment.duration))
    report_violation("I14", second,
                     fmt::format("segment {} ended after {} s and {} s without a row, expected {}", index + 1, clock,
                                 unseen, seconds(segment.duration)));
  if (segment.guaranteed_soak && soaked < seconds(segment.soak_time))
    report_violation(
        "I14", second,
        fmt::format("segment {} soaked for {} s, expected {}", index + 1, soaked, seconds(segment.soak_time)));
}

/// I14, I15: judges the order and the ends of segments.
void Invariants::judge_segments(std::int64_t second, const Sample& sample) {
  const int index = sample.progress.segment;
  if (!rows_.empty() && index < rows_.back().segment)
    report_violation("I15", second, fmt::format("segment {} after {}", index + 1, rows_.back().segment + 1));
  for (int ended = rows_.empty() ? index : rows_.back().segment; ended < index; ++ended)
    judge_segment_end(second, ended);
  const auto& segment = profile_.segments[static_cast<std::size_t>(index)];
  const auto& chamber = sample.chamber.value;
  const bool in_band = chamber && segment.guaranteed_soak && abs(chamber->air - segment.target) <= segment.soak_band;
  LogHash values;
  values.add(sample);
  rows_.push_back({sample.slot, index, sample.state, in_band, values.value()});
}

namespace {

/// Returns the number of consecutive rows for which readings of an instrument may be identical and still be stored as
/// good: a minute plus the time until the instrument's noise is known, or five times the longest earlier spell plus a
/// margin, whichever is larger.
std::int64_t max_identical_rows(std::int64_t before) {
  constexpr std::int64_t kNoiseIsKnown = 300, kTimes = 5, kMargin = 60;
  return std::max(kNoiseIsKnown, kTimes * before + kMargin);
}

}  // namespace

/// I25: no value of a frozen instrument, and no count of a dead gyro, is stored as good for longer than its limit. The
/// instrument's noise must have been learned before.
void Invariants::judge_liveness(std::int64_t second, const Sample& sample) {
  constexpr std::int64_t kLearned = 900, kMargin = 5;
  ++ticks_of_life_;
  identical_.resize(file_.limits.instruments.size());
  for (std::size_t k = 0; k < identical_.size(); ++k) {
    const auto& instrument = file_.limits.instruments[k];
    std::vector<double> values;
    for (const auto i : instrument.columns)
      if (const auto& reading = sample.thermometers[i].value) values.push_back(reading->value);
    auto& seen = identical_[k];
    if (values.size() < instrument.columns.size() || values.size() < 2) continue;
    const bool same = values == seen.last;
    if (!same) seen.longest = std::max(seen.longest, seen.rows);
    seen.rows = same ? seen.rows + 1 : 0;
    seen.last = std::move(values);
    if (ticks_of_life_ - seen.rows > kLearned && seen.rows > max_identical_rows(seen.longest))
      report_violation("I25", second,
                       fmt::format("{} identical for {} rows, and stored as good", instrument.name, seen.rows));
  }
  without_counts_.resize(sample.units.size());
  for (std::size_t unit = 0; unit < sample.units.size(); ++unit) {
    const auto& count = sample.units[unit].count.value;
    const bool none =
        count && !count->pulses.empty() && std::ranges::all_of(count->pulses, [](auto n) { return n == 0; });
    without_counts_[unit] = none ? without_counts_[unit] + 1 : 0;
    if (without_counts_[unit] > file_.limits.gyro_dead_after / std::chrono::seconds(1) + kMargin)
      report_violation("I25", second, fmt::format("gyro {} has no counts for {} rows", unit, without_counts_[unit]));
  }
}

/// I26: a limit that is exceeded in k of the last 2 k readings acts immediately, regardless of lost readings between
/// them.
void Invariants::judge_limits(std::int64_t second, const Sample& sample) {
  const auto& limits = file_.limits;
  const auto all = sample.thermometers.size();
  beyond_.resize(all + 1);
  const auto add = [&](std::size_t i, bool is_beyond) {
    auto& last = beyond_[i];
    last.push_back(is_beyond);
    if (std::ssize(last) > 2 * limits.confirming_samples) last.erase(last.begin());
    if (is_beyond && std::ranges::count(last, true) >= limits.confirming_samples &&
        severity(sample.state) < severity(RunState::aborting))
      report_violation("I26", second, fmt::format("column {} is outside its limit in state {}", i, name(sample.state)));
  };
  for (std::size_t i = 0; i < all; ++i)
    if (const auto& value = sample.thermometers[i].value)
      add(i, *value < limits.thermometers_lowest || *value > limits.thermometers_highest);
  if (const auto& chamber = sample.chamber.value)
    add(all, chamber->air < limits.air_lowest || chamber->air > limits.air_highest);
}

/// I27: no run ends while the air moves away from the safe set point, or in a mode that does not follow it.
void Invariants::check_end_of_safe_run(std::int64_t second) {
  constexpr double kMargin = 1.5;
  const auto& laboratory = plant_.laboratory();
  if (laboratory.is_on() && laboratory.holds_output())
    report_violation("I27", second, "the chamber remains in manual mode");
  const bool is_quiet = injector_.last_change() < second - 60 && !from_safe_k_.empty();
  if (is_quiet && from_safe_k_.back() > from_safe_k_.front() + kMargin)
    report_violation("I27", second,
                     fmt::format("the air is {} K from the safe set point, {} K a minute ago", from_safe_k_.back(),
                                 from_safe_k_.front()));
}

void Invariants::completed(std::int64_t second) {
  const int last = static_cast<int>(profile_.segments.size()) - 1;
  if (rows_.empty() || rows_.back().segment != last)
    report_violation("I15", second, "complete before the last segment");
  judge_segment_end(second, last);
}

void Invariants::count_ticks(const Sample& sample) {
  auto& ticks = quiet_ticks_;
  const auto count = [](std::int64_t& ticks_so_far, bool so) { ticks_so_far = so ? ticks_so_far + 1 : 0; };
  const auto& laboratory = plant_.laboratory();
  const bool tcp = plant_.chamber().is_tcp();
  const bool line = is_active(Kind::chamber_silent, Kind::chamber_wrong_number) ||
                    is_active(Kind::air_sensor_broken, Kind::air_sensor_broken);
  const bool dead = is_active(Kind::chamber_silent, Kind::chamber_answers_lost) ||
                    is_active(Kind::chamber_exception, Kind::chamber_exception) ||
                    is_active(Kind::chamber_foreign_unit, Kind::chamber_foreign_unit) ||
                    (tcp && is_active(Kind::chamber_wrong_number, Kind::chamber_wrong_number)) ||
                    is_active(Kind::air_sensor_broken, Kind::air_sensor_broken);
  count(ticks.link_bad, dead);
  count(ticks.link_good, !line);
  const bool good = ticks.link_good >= kLinkSettles;
  std::size_t silent_lines = 0;
  for (std::size_t i = 0; i < plant_.thermometer_count(); ++i)
    silent_lines += plant_.thermometer(i).trouble.silent || plant_.thermometer(i).trouble.gone ? 1 : 0;
  count(ticks.thermometers_bad, silent_lines == plant_.thermometer_count());
  count(ticks.door, good && is_active(Kind::door_open, Kind::door_open));
  count(ticks.off, good && !laboratory.is_on());
  const auto tolerance = drivers::set_point_tolerance(file_.chamber_map) + kSame;
  count(ticks.other_set_point, good && sent_before_ && abs(in_force_ - *sent_before_) > tolerance);
  const auto& limits = file_.limits;
  const auto outside = [&](const auto& reading) {
    return reading.value &&
           (*reading.value < limits.thermometers_lowest || *reading.value > limits.thermometers_highest);
  };
  const bool air = sample.chamber.value &&
                   (sample.chamber.value->air < limits.air_lowest || sample.chamber.value->air > limits.air_highest);
  count(ticks.beyond, (air ? 1 : 0) + std::ranges::count_if(sample.thermometers, outside) >= 2);
  // A chamber that reads back the safe set point is accepted, whichever client sent it.
  const bool reads_back = abs(laboratory.set_point() - file_.safe_set_point) <= tolerance;
  const bool safe = reads_back || !laboratory.is_on();
  const bool obeys = !is_active(Kind::chamber_ignores_writes, Kind::chamber_clamps);
  const bool lossy_alone = injector_.active_faults().size() == 1 && is_active(Kind::chamber_lossy, Kind::chamber_lossy);
  count(ticks.lossy, lossy_alone && severity(sample.state) == severity(RunState::aborting) && !safe);
  count(ticks.aborting, good && obeys && severity(sample.state) == severity(RunState::aborting) && !safe);
}

/// I7, I8, I9, I20: judges the reactions to lasting causes.
void Invariants::judge_reactions(std::int64_t second, const Sample& sample) {
  const auto& ticks = quiet_ticks_;
  const int is = severity(sample.state);
  const auto seconds = [](Duration time) { return time / std::chrono::seconds(1); };
  const auto want = [&](bool due, RunState least, const char* cause) {
    if (due && is < severity(least))
      report_violation("I7", second,
                       fmt::format("{}: in state {}, expected {}", cause, name(sample.state), name(least)));
  };
  want(ticks.link_bad > seconds(file_.limits.suspend_after) + 3, RunState::suspended, "the chamber does not answer");
  want(ticks.link_bad > seconds(file_.limits.chamber_lost) + 15, RunState::aborting, "the chamber is lost");
  want(ticks.thermometers_bad > 12, RunState::suspended, "every thermometer is silent");
  want(ticks.door > 2 * file_.chamber_map.status_every + 2, RunState::suspended, "the door is open");
  want(ticks.off > 2 * file_.chamber_map.status_every + 8, RunState::suspended, "the chamber is off");
  want(ticks.other_set_point > 4, RunState::suspended, "the chamber has another set point");
  want(ticks.beyond > 4, RunState::aborting, "two sensors are outside their limits");
  const bool calm = injector_.active_faults().empty() && second - injector_.last_change() > kRecoversWithin;
  if (calm && sample.state == RunState::suspended && ticks.off == 0 && ticks.other_set_point == 0)
    report_violation("I20", second, "still suspended, long after the last fault");
  if (ticks.aborting > 10)
    report_violation("I9", second, "the safe set point is not in the chamber 10 s after the abort");
  if (ticks.lossy > 20) report_violation("I9", second, "a line that loses exchanges keeps the chamber from being safe");
}

/// I16: a resumed run continues in the same segment or after its end, and counts only soak seconds that have a row.
void Invariants::judge_resume(std::int64_t second, const ProfilePosition& at) {
  if (rows_.empty()) {
    if (at.segment != 0) report_violation("I16", second, "the run does not begin with the first segment");
    return;
  }
  const auto segment = rows_.back().segment;
  if (at.segment != segment && at.segment != segment + 1)
    report_violation("I16", second, fmt::format("segment {} after {}", at.segment + 1, segment + 1));
  Duration clock{}, soaked{};
  for (auto row = rows_.rbegin(); row != rows_.rend() && row->segment == at.segment; ++row) {
    if (row->state != RunState::execute) continue;
    clock += std::chrono::seconds(1);
    soaked += std::chrono::seconds(row->in_band ? 1 : 0);
  }
  const bool guaranteed = profile_.segments[static_cast<std::size_t>(at.segment)].guaranteed_soak;
  if (at.in_segment > clock || (guaranteed && at.soaked > soaked))
    report_violation(
        "I16", second,
        fmt::format("{} in the segment and {} of soak, the rows have {} and {}", format_duration(at.in_segment),
                    format_duration(at.soaked), format_duration(clock), format_duration(soaked)));
}

/// Compares the record with the rows that were appended to it. Rows that were not acknowledged may be missing at the
/// end. Other rows may be missing only if the record reports the reason: memory overflow, or a destroyed file.
void Invariants::judge_record(std::int64_t second, const record::Record& record, std::int64_t acknowledged,
                              bool left_unwritten) {
  auto given = rows_.begin();
  auto gap = record.gaps.begin();
  std::int64_t next = 0;
  const auto pass_gaps = [&] {
    for (; gap != record.gaps.end() && gap->first == next; ++gap) {
      next = gap->last + 1;
      if (gap->cause == record::kDropped || gap->cause.starts_with("lost with "))
        while (given != rows_.end() && given->slot < next) ++given;
    }
  };
  for (std::size_t i = 0; i < record.slot.size(); ++i, ++given, ++next) {
    pass_gaps();
    const auto& at = record.progress[i];
    if (record.slot[i] != next || given == rows_.end() || given->slot != next)
      return report_violation("I10", second, fmt::format("the record has slot {}, expected {}", record.slot[i], next));
    if (at.segment != given->segment || record.state[i] != given->state)
      return report_violation("I13", second, fmt::format("slot {} differs from the appended sample", next));
  }
  pass_gaps();
  const auto count = std::min(record.info.segments.size(), profile_.segments.size());
  for (std::size_t i = 0; i < count; ++i)
    if (const auto& name = profile_.segments[i].name; record.info.segments[i].name != name)
      report_violation("I29", second,
                       fmt::format("segment {} is recorded as \"{}\", carried out as \"{}\"", i + 1,
                                   record.info.segments[i].name, name));
  for (const auto& at : record.progress)
    if (static_cast<std::size_t>(at.segment) >= record.info.segments.size())
      return report_violation("I29", second, fmt::format("the record does not describe segment {}", at.segment + 1));
  if (next - 1 < acknowledged)
    report_violation("P1", second, fmt::format("the record ends at {}, {} was acknowledged", next - 1, acknowledged));
  if (given != rows_.end() && !left_unwritten)
    report_violation("I10", second, fmt::format("rows from {} are missing in the record", given->slot));
}

void Invariants::after_tick(std::int64_t second, const RecordingStore& recording, const Operators& operators) {
  judge_rows(second, recording);
  judge_alarms(second, recording);
  if (!recording.sample()) return;
  const auto& sample = *recording.sample();
  judge_set_points(second, sample);
  judge_values(second, sample);
  judge_identities(second, sample);
  judge_state(second, sample);
  judge_machine(second, recording, sample.state);
  judge_units(second, sample, operators);
  judge_channels(second, recording, sample, operators);
  judge_segments(second, sample);
  judge_liveness(second, sample);
  judge_limits(second, sample);
  constexpr std::size_t kMinute = 60;
  from_safe_k_.push_back(std::abs((plant_.laboratory().air_as_measured() - file_.safe_set_point).value));
  if (from_safe_k_.size() > kMinute) from_safe_k_.pop_front();
  count_ticks(sample);
  judge_reactions(second, sample);
}

}  // namespace gyrotherm::faults
