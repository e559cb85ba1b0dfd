#include "sequencer/interlocks/interlock_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm {
namespace {

constexpr CelsiusPerMinute kNoAir{120};  ///< moves so fast; where a rig has faster air: nor three times as fast as that
constexpr int kStuckSamples = 120;
constexpr Kelvins kOthersMoved{0.5};
constexpr Duration kWallStep = std::chrono::milliseconds(50);
constexpr int kRefusals = 3;
constexpr Kelvins kNearLimit{2};

/// The thermometers that answer, by size.
class Ranks {
 public:
  explicit Ranks(const Sample& sample) {
    for (const auto& reading : sample.thermometers)
      if (reading.value) sorted_.push_back(reading.value->value);
    std::sort(sorted_.begin(), sorted_.end());
  }
  [[nodiscard]] std::optional<Celsius> median() const {
    return sorted_.empty() ? std::nullopt : std::optional(Celsius{sorted_[sorted_.size() / 2]});
  }
  /// Of the others; `own` is one of them if it is known.
  [[nodiscard]] std::optional<Celsius> median_without(const std::optional<Celsius>& own) const {
    if (!own) return median();
    if (sorted_.size() < 2) return std::nullopt;
    const auto middle = (sorted_.size() - 1) / 2;
    const bool after = own->value <= sorted_[middle];
    return Celsius{sorted_[after ? middle + 1 : middle]};
  }

 private:
  std::vector<double> sorted_;
};

std::optional<Celsius> median(const Sample& sample, const std::vector<std::size_t>& columns) {
  Sample few;
  for (const auto column : columns) few.thermometers.push_back(sample.thermometers[column]);
  return Ranks(few).median();
}

class InterlockChecks {
 public:
  InterlockChecks(const InterlockLimits& limits, const InterlockMemory& memory, const Sample& sample,
                  const InterlockInputs& around)
      : limits_(limits), memory_(memory), sample_(sample), around_(around), ranks_(sample) {}

  CheckResults all() {
    at_limits();
    at_silence();
    if (sample_.chamber.value) {
      at_the_chamber(*sample_.chamber.value);
      at_its_set_point(*sample_.chamber.value);
      at_its_sensor(sample_.chamber.value->air);
    }
    at_rates();
    at_neighbours();
    at_the_program();
    at_what_was_not_read();
    return std::move(findings_);
  }

 private:
  void found(InterlockId cause, std::string text, bool grave = false) {
    findings_.found[static_cast<std::size_t>(cause)] = CheckResult{.text = std::move(text), .grave = grave};
  }
  void found_at(std::size_t column, InterlockId cause, std::string text) {
    findings_.found[static_cast<std::size_t>(cause)] = CheckResult{.text = std::move(text), .column = column};
  }
  void hidden(InterlockId cause, bool is_so) { findings_.hidden[static_cast<std::size_t>(cause)] = is_so; }
  [[nodiscard]] bool stands(InterlockId cause) const { return memory_.of(cause).samples > 0; }
  [[nodiscard]] std::string channel(std::size_t column) const {
    return column < limits_.channels.size() ? "thermometer " + limits_.channels[column] : "a thermometer";
  }

  void at_limits() {
    if (sample_.chamber.value) {
      const auto air = sample_.chamber.value->air;
      if (!(air >= limits_.air_lowest && air <= limits_.air_highest))
        found(InterlockId::air_limit, fmt::format("chamber air {:.2f} °C is outside {:g} … {:g} °C", air.value,
                                                  limits_.air_lowest.value, limits_.air_highest.value));
    }
    for (std::size_t i = 0; i < sample_.thermometers.size(); ++i) {
      const auto value = value_of(sample_.thermometers[i]);
      const auto own = i < limits_.thermometers.size()
                           ? limits_.thermometers[i]
                           : ThermometerLimits{limits_.thermometers_lowest, limits_.thermometers_highest};
      if (!value || (*value >= own.lowest && *value <= own.highest)) continue;
      return found_at(i, InterlockId::thermometer_limit,
                      fmt::format("{} reads {:.2f} °C, outside {:g} … {:g} °C", channel(i), value->value,
                                  own.lowest.value, own.highest.value));
    }
  }

  void at_silence() {
    const auto answer = std::count_if(sample_.thermometers.begin(), sample_.thermometers.end(),
                                      [](const auto& reading) { return reading.value.has_value(); });
    const auto needed =
        std::min<std::ptrdiff_t>(limits_.thermometers_needed, static_cast<std::ptrdiff_t>(sample_.thermometers.size()));
    if (!sample_.chamber.value) at_a_silent_chamber();
    if (answer < needed)
      found(InterlockId::thermometers_lost, answer == 0
                                                ? "every thermometer silent"
                                                : fmt::format("{} thermometers answer, {} are needed", answer, needed));
    if (!sample_.gyro.value) found(InterlockId::gyro_silent, "gyro silent");
    at_lost_channels();
  }

  void at_lost_channels() {
    std::vector<std::string> lost, needed;
    for (std::size_t i = 0; i < sample_.thermometers.size(); ++i) {
      if (sample_.thermometers[i].value) continue;
      lost.push_back(channel(i));
      if (std::ranges::count(limits_.needed_thermometers, i) > 0) needed.push_back(channel(i));
    }
    const auto in_words = [](const auto& names) { return fmt::format("no reading of {}", fmt::join(names, ", ")); };
    if (!lost.empty()) found(InterlockId::channel_lost, in_words(lost));
    if (!needed.empty()) found(InterlockId::needed_channel_lost, in_words(needed) + ", which the analysis needs");
  }

  /// Somebody else's set point is not known to be gone: after the silence it is still that, and no restart.
  void at_a_silent_chamber() {
    found(InterlockId::chamber_silent, "chamber silent");
    if (stands(InterlockId::foreign_set_point))
      found(InterlockId::foreign_set_point, memory_.of(InterlockId::foreign_set_point).text);
  }

  void at_the_chamber(const ChamberState& chamber) {
    if (chamber.must_stop)
      found(InterlockId::chamber_alarm,
            fmt::format("chamber alarm: {}", chamber.alarms.empty() ? "unnamed" : chamber.alarms.front()));
    switch (chamber.activity) {
      case ChamberActivity::emergency_stop:
        return found(InterlockId::emergency_stop, "the chamber's emergency stop is pressed");
      case ChamberActivity::door_open: return found(InterlockId::door, "the chamber's door is open");
      case ChamberActivity::power_failure: return found(InterlockId::supply, "the chamber has lost its supply");
      default: return;
    }
  }

  void at_its_set_point(const ChamberState& chamber) {
    if (around_.led_by_controller) return;
    if (around_.refusals >= kRefusals)
      found(InterlockId::not_taken, fmt::format("the chamber does not take set points: {}", around_.refusal));
    const bool off = chamber.activity == ChamberActivity::off;
    const bool other = around_.sent && abs(chamber.set_point - *around_.sent) > around_.set_point_tolerance;
    const bool program = around_.sent && carries_out_program(chamber.activity);
    if (!off && !other && !program) return;
    const auto what = off       ? std::string("is switched off")
                      : program ? std::string("carries out a program of its own")
                                : fmt::format("has the set point {:g} °C, it was sent {:g} °C", chamber.set_point.value,
                                              around_.sent->value);
    const bool silent_before = !memory_.chamber_answered || (off && !memory_.activity_seen);
    const bool was_silent = silent_before && !stands(InterlockId::foreign_set_point);
    if (was_silent || stands(InterlockId::restarted))
      found(InterlockId::restarted, "the chamber was restarted: it " + what);
    else if (around_.refusals == 0)
      found(InterlockId::foreign_set_point, "somebody else changed it: the chamber " + what);
  }

  /// The air follows its set point like a first-order lag, and three times as slowly at the worst.
  void at_following(Celsius air) {
    if (!memory_.expected || !memory_.set_point) return;
    const auto band = std::max(limits_.follow_band, memory_.lag * 3);
    if (abs(air - *memory_.expected) <= band) return;
    const bool near_a_limit = air < limits_.air_lowest + kNearLimit || air > limits_.air_highest - kNearLimit;
    found(InterlockId::following,
          fmt::format("the air does not follow the set point: {:.1f} °C, expected {:.1f} °C", air.value,
                      memory_.expected->value),
          near_a_limit);
  }

  void at_its_sensor(Celsius air) {
    at_following(air);
    if (limits_.air_thermometers.empty()) {
      if (abs(memory_.air_jumped) > limits_.chamber_disagreement)
        found(InterlockId::chamber_sensor,
              fmt::format("the chamber's sensor jumped by {:+.1f} K, as no air does: {:.1f} °C",
                          memory_.air_jumped.value, air.value));
      return;
    }
    const auto others = median(sample_, limits_.air_thermometers);
    if (!others || abs(air - *others) <= limits_.chamber_disagreement) return;
    found(InterlockId::chamber_sensor,
          fmt::format("the chamber's sensor shows {:.1f} °C, the thermometers {:.1f} °C", air.value, others->value));
  }

  void at_rates() {
    if (const auto rate = memory_.air.rate(); rate && std::abs(rate->value) > limits_.air_fastest.value)
      found(InterlockId::air_rate, fmt::format("the chamber's air changes by {:.1f} °C in a minute", rate->value));
    for (std::size_t i = 0; i < memory_.thermometers.size(); ++i)
      if (const auto rate = memory_.thermometers[i].rate();
          rate && std::abs(rate->value) > limits_.thermometers_fastest.value)
        found_at(i, InterlockId::thermometer_rate,
                 fmt::format("{} changes by {:.1f} °C in a minute", channel(i), rate->value));
  }

  void at_neighbours() {
    for (std::size_t i = 0; i < sample_.thermometers.size(); ++i) {
      const auto value = value_of(sample_.thermometers[i]);
      const auto others = ranks_.median_without(value);
      if (!value || !others) continue;
      if (abs(*value - *others) > limits_.disagreement)
        found_at(i, InterlockId::disagreement,
                 fmt::format("{} reads {:.1f} °C, the others {:.1f} °C", channel(i), value->value, others->value));
      const auto& trend = memory_.thermometers[i];
      if (trend.unchanged_samples() >= kStuckSamples && trend.others_moved() > kOthersMoved)
        found_at(i, InterlockId::stuck,
                 fmt::format("{} stands at {:.3f} °C while the others move", channel(i), value->value));
    }
  }

  void at_the_program() {
    if (sample_.progress.phase == Phase::overdue)
      found(InterlockId::deadline, fmt::format("segment {} passed its deadline", sample_.progress.segment + 1));
    if (!around_.program.empty()) found(InterlockId::program, around_.program);
    if (around_.missed > around_.longest_missed)
      found(InterlockId::slept, fmt::format("the machine stood still for {}", spoken(around_.missed)));
    if (around_.rows_dropped)
      found(InterlockId::storage, "the record loses rows");
    else if (around_.backlog > limits_.backlog)
      found(InterlockId::storage, fmt::format("the record is {} behind{}{}", spoken(around_.backlog),
                                              around_.storage_trouble.empty() ? "" : ": ", around_.storage_trouble));
    if (!around_.record_damage.empty()) found(InterlockId::record_damaged, around_.record_damage);
    if (!around_.guard_trouble.empty()) found(InterlockId::unguarded, around_.guard_trouble);
    if (!memory_.utc_minus_run) return;
    const auto step = sample_.at.utc - sample_.at.since_start - *memory_.utc_minus_run;
    if (std::chrono::abs(step) > kWallStep)
      found(InterlockId::wall_clock, fmt::format("the time of day was stepped by {:+.3f} s", to_seconds(step)));
  }

  void at_what_was_not_read() {
    const bool silent = !sample_.chamber.value;
    for (const auto cause :
         {InterlockId::air_limit, InterlockId::chamber_alarm, InterlockId::emergency_stop, InterlockId::door,
          InterlockId::supply, InterlockId::not_taken, InterlockId::restarted, InterlockId::following})
      hidden(cause, silent);
    hidden(InterlockId::air_rate, !memory_.air.rate());
    const bool compares = !limits_.air_thermometers.empty();
    hidden(InterlockId::chamber_sensor, silent || (compares && !median(sample_, limits_.air_thermometers)));
    for (const auto cause :
         {InterlockId::thermometer_limit, InterlockId::thermometer_rate, InterlockId::disagreement, InterlockId::stuck})
      hidden(cause, was_not_read(memory_.of(cause).column, cause));
  }

  /// What showed the cause when it was last seen.
  [[nodiscard]] bool was_not_read(const std::optional<std::size_t>& column, InterlockId cause) const {
    if (!column || *column >= sample_.thermometers.size()) return false;
    const auto value = value_of(sample_.thermometers[*column]);
    if (cause == InterlockId::thermometer_rate) return !memory_.thermometers[*column].rate();
    if (cause == InterlockId::thermometer_limit) return !value;
    return !value || !ranks_.median_without(value);
  }

  const InterlockLimits& limits_;
  const InterlockMemory& memory_;
  const Sample& sample_;
  const InterlockInputs& around_;
  Ranks ranks_;
  CheckResults findings_;
};

/// Air moves through the degrees, a sensor that breaks skips them: what it skips adds up, and is forgotten where it is
/// little. What its controller then does about the air does not hide it.
void add_jump(const InterlockLimits& limits, const std::optional<Celsius>& air, Duration elapsed,
              InterlockMemory& memory) {
  constexpr double kTimesTheFastest = 3;
  memory.air_unseen += elapsed;
  if (!air) return;
  const auto before = std::exchange(memory.air_seen, air);
  const auto unseen = std::exchange(memory.air_unseen, Duration{});
  if (!before) return;
  const CelsiusPerMinute fastest{std::max(kNoAir.value, kTimesTheFastest * limits.air_fastest.value)};
  if (abs(*air - *before) > fastest * unseen)
    memory.air_jumped = memory.air_jumped + (*air - *before);
  else if (abs(memory.air_jumped) <= limits.chamber_disagreement)
    memory.air_jumped = {};
}

/// The air as it would follow the set point that the controller holds; `elapsed` since it was last read.
void expect_air(const InterlockLimits& limits, const ChamberState& chamber, Duration elapsed, InterlockMemory& memory) {
  if (std::isnan(chamber.set_point.value)) return;
  memory.set_point = chamber.set_point;
  if (!memory.expected) memory.expected = chamber.air;
  const double share = 1 - std::exp(-to_seconds(elapsed) / to_seconds(limits.chamber_lag));
  memory.expected = *memory.expected + (chamber.set_point - *memory.expected) * share;
  const auto faded = memory.lag * std::exp(-to_seconds(elapsed) / (3 * to_seconds(limits.chamber_lag)));
  memory.lag = std::max(faded, abs(chamber.set_point - *memory.expected));
}

}  // namespace

void remember(const InterlockLimits& limits, const Sample& sample, Duration elapsed, const InterlockInputs& inputs,
              InterlockMemory& memory) {
  memory.thermometers.resize(sample.thermometers.size());
  if (inputs.missed > Duration{}) {
    memory.air.forget();
    for (auto& trend : memory.thermometers) trend.forget();
  }
  const auto& chamber = sample.chamber.value;
  const auto air = chamber ? std::optional(chamber->air) : std::nullopt;
  const auto since_seen = memory.air_unseen + elapsed;
  memory.air.add(air);
  add_jump(limits, air, elapsed, memory);
  const Ranks ranks(sample);
  if (chamber) expect_air(limits, *chamber, since_seen, memory);
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i) {
    const auto value = value_of(sample.thermometers[i]);
    memory.thermometers[i].add(value);
    memory.thermometers[i].compare(ranks.median_without(value));
  }
}

CheckResults run_checks(const InterlockLimits& limits, const InterlockMemory& memory, const Sample& sample,
                        const InterlockInputs& inputs) {
  return InterlockChecks(limits, memory, sample, inputs).all();
}

}  // namespace gyrotherm
