// SPDX-License-Identifier: Apache-2.0
#include "sequencer/interlocks/interlock_memory.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace gyrotherm::interlocks {
namespace {

constexpr Kelvins kMinChange{0.001};

/// Sums changes of the air temperature that are too fast to be real. Real air temperature changes gradually; only a
/// broken sensor jumps. A sum within chamber_disagreement is reset at the next plausible change. A greater sum is kept,
/// even if the controller heats or cools in response.
void add_jump(const InterlockLimits& limits, const std::optional<Celsius>& air, Duration elapsed,
              InterlockMemory& memory) {
  constexpr double kTimesTheFastest = 3;
  memory.since_last_air += elapsed;
  if (!air) return;
  const auto before = std::exchange(memory.last_air, air);
  const auto unseen = std::exchange(memory.since_last_air, Duration{});
  if (!before) return;
  const CelsiusPerMinute fastest{std::max(kFastestPlausibleAir.value, kTimesTheFastest * limits.air_fastest.value)};
  const auto change = *air - *before;
  if (abs(change) > fastest * unseen) {
    memory.air_jump_sum = memory.air_jump_sum + change;
    memory.explained.lowest = memory.explained.lowest + change;
    memory.explained.highest = memory.explained.highest + change;
  } else if (abs(memory.air_jump_sum) <= limits.chamber_disagreement) {
    memory.air_jump_sum = {};
  }
}

/// Extends the range that the set points explain, and decides whether the air has followed them. A time without
/// readings counts for at most two seconds.
void explain_air(const InterlockLimits& limits, const ChamberState& chamber, Duration elapsed,
                 InterlockMemory& memory) {
  constexpr Kelvins kFar{10};
  constexpr Duration kLongEnough = std::chrono::minutes(1), kInRange = std::chrono::minutes(30);
  constexpr Duration kLongestUnseen = std::chrono::seconds(2);
  auto& known = memory.explained;
  const auto set_point = chamber.set_point;
  if (!known.first) {
    known.first = chamber.air;
    known.lowest = known.highest = chamber.air;
  }
  const auto seen = std::min(elapsed, kLongestUnseen);
  known.watched += seen;
  known.lowest = std::min(known.lowest, set_point);
  known.highest = std::max(known.highest, set_point);
  const bool is_at_rest = memory.set_point && abs(set_point - *memory.set_point) < kMinChange;
  const bool is_near = abs(chamber.air - set_point) <= limits.follow_band && abs(set_point - *known.first) >= kFar;
  known.near_set_point = is_at_rest && is_near ? known.near_set_point + seen : Duration{};
  known.has_followed = known.has_followed || known.near_set_point >= kLongEnough || known.watched >= kInRange;
}

/// Predicts the air from the controller's set point as a first-order lag. `elapsed` is the time since the last reading.
void predict_air(const InterlockLimits& limits, const ChamberState& chamber, Duration elapsed,
                 InterlockMemory& memory) {
  if (std::isnan(chamber.set_point.value)) return;
  explain_air(limits, chamber, elapsed, memory);
  memory.set_point = chamber.set_point;
  if (!memory.expected) memory.expected = chamber.air;
  const double share = 1 - std::exp(-to_seconds(elapsed) / to_seconds(limits.chamber_lag));
  memory.expected = *memory.expected + (chamber.set_point - *memory.expected) * share;
  const auto faded = memory.lag * std::exp(-to_seconds(elapsed) / (3 * to_seconds(limits.chamber_lag)));
  memory.lag = std::max(faded, abs(chamber.set_point - *memory.expected));
}

}  // namespace

void Trend::add(std::optional<Celsius> value) {
  newest_ = (newest_ + 1) % static_cast<int>(ring_.size());
  ring_[static_cast<std::size_t>(newest_)] = value ? value->value : std::numeric_limits<double>::quiet_NaN();
  filled_ = std::min(filled_ + 1, static_cast<int>(ring_.size()));
  if (!value) return;
  if (unchanged_value_ && abs(*value - *unchanged_value_) < kMinChange) {
    ++unchanged_;
  } else {
    unchanged_value_ = value;
    unchanged_ = 1;
    others_at_last_change_.reset();
    others_moved_ = {};
  }
}

void Trend::forget() { *this = {}; }

std::optional<CelsiusPerMinute> Trend::rate() const {
  if (filled_ < static_cast<int>(ring_.size())) return std::nullopt;
  const auto size = static_cast<int>(ring_.size());
  const auto now = ring_[static_cast<std::size_t>(newest_)];
  const auto then = ring_[static_cast<std::size_t>((newest_ + 1) % size)];
  if (std::isnan(now) || std::isnan(then)) return std::nullopt;
  return CelsiusPerMinute{now - then};
}

void Trend::compare(std::optional<Celsius> others) {
  if (!others) return;
  if (!others_at_last_change_) others_at_last_change_ = others;
  others_moved_ = abs(*others - *others_at_last_change_);
}

InterlockMemory::Watch InterlockMemory::most_affected_watch(InterlockId id) const {
  const auto& all = watches[static_cast<std::size_t>(id)];
  const auto weight = [](const Watch& watch) { return std::pair(watch.raised, watch.samples > 0); };
  const auto most = std::ranges::max_element(all, {}, weight);
  return most != all.end() ? *most : Watch{};
}

bool InterlockMemory::is_cause_present(InterlockId id) const {
  const auto& all = watches[static_cast<std::size_t>(id)];
  return std::ranges::any_of(all, [](const Watch& watch) { return watch.samples > 0; });
}

bool InterlockMemory::is_cause_present(InterlockId id, const std::string& subject) const {
  const auto& all = watches[static_cast<std::size_t>(id)];
  return std::ranges::any_of(all, [&](const Watch& watch) { return watch.subject == subject && watch.samples > 0; });
}

bool InterlockMemory::is_active(InterlockId id) const {
  const auto& all = watches[static_cast<std::size_t>(id)];
  return std::ranges::any_of(all, [](const Watch& watch) { return watch.samples > 0 && watch.raised; });
}

Ranks::Ranks(const Sample& sample) {
  for (const auto& reading : sample.thermometers)
    if (reading.value) sorted_.push_back(reading.value->value);
  std::sort(sorted_.begin(), sorted_.end());
}

std::optional<Celsius> Ranks::median() const {
  if (sorted_.empty()) return std::nullopt;
  return Celsius{(sorted_[(sorted_.size() - 1) / 2] + sorted_[sorted_.size() / 2]) / 2};
}

std::optional<Celsius> Ranks::median_without(const std::optional<Celsius>& own) const {
  if (!own) return median();
  if (sorted_.size() < 2) return std::nullopt;
  const auto at = static_cast<std::size_t>(std::ranges::lower_bound(sorted_, own->value) - sorted_.begin());
  const auto other = [&](std::size_t k) { return sorted_[k < at ? k : k + 1]; };
  const auto others = sorted_.size() - 1;
  return Celsius{(other((others - 1) / 2) + other(others / 2)) / 2};
}

namespace {

/// Rates are compared once the set point has been constant for kMinRestTime.
constexpr Duration kMinRestTime = std::chrono::minutes(20);
/// Decay of the rate at which the slowest part approaches the air.
constexpr Duration kRateDecay = std::chrono::minutes(40);
constexpr std::size_t kFewestRates = 3;  ///< needed for a comparison

/// Updates the differences of the thermometers' rates from their median.
void compare_rates(Duration elapsed, InterlockMemory& memory) {
  auto& differences = memory.rate_differences;
  differences.resize(memory.thermometers.size());
  std::vector<double> rates;
  for (const Trend& trend : memory.thermometers)
    if (const auto rate = trend.rate()) rates.push_back(rate->value);
  if (memory.liveness.at_rest < kMinRestTime || rates.size() < kFewestRates) {
    std::ranges::fill(differences, std::nullopt);
    return;
  }
  const auto middle = rates.begin() + static_cast<std::ptrdiff_t>(rates.size() / 2);
  std::ranges::nth_element(rates, middle);
  const double decay = std::exp(-to_seconds(elapsed) / to_seconds(kRateDecay));
  for (std::size_t i = 0; i < differences.size(); ++i) {
    const auto rate = memory.thermometers[i].rate();
    if (!rate) {
      differences[i].reset();
      continue;
    }
    const double now = rate->value - *middle;
    const double before = differences[i] ? differences[i]->least * decay : std::abs(now);
    differences[i] = RateDifference{.now = now, .least = std::min(before, std::abs(now))};
  }
}

}  // namespace

void note_alteration(bool is_altered, const ExplainedAir& before, const ChamberState& chamber,
                     InterlockMemory& memory) {
  auto& kept = memory.explained_before_alteration;
  if (is_altered && !kept) kept = before;
  const bool is_another = is_altered && memory.altered_to && abs(chamber.set_point - *memory.altered_to) >= kMinChange;
  memory.altered_to = is_altered ? std::optional(chamber.set_point) : std::nullopt;
  if (!kept || (is_altered && !is_another)) return;
  const auto shown = is_altered ? chamber.set_point : chamber.air;
  const auto lowest = std::min(chamber.air, shown), highest = std::max(chamber.air, shown);
  memory.explained.lowest = kept->first ? std::min(kept->lowest, lowest) : lowest;
  memory.explained.highest = kept->first ? std::max(kept->highest, highest) : highest;
  memory.expected = chamber.air;
  memory.lag = is_altered ? abs(chamber.set_point - chamber.air) : Kelvins{};
  if (!is_altered) kept.reset();
}

void remember(const InterlockLimits& limits, const Sample& sample, Duration elapsed, bool is_after_pause,
              InterlockMemory& memory) {
  memory.thermometers.resize(sample.thermometers.size());
  if (is_after_pause) {
    memory.air.forget();
    for (auto& trend : memory.thermometers) trend.forget();
  }
  const auto& chamber = sample.chamber.value;
  const auto air = chamber ? std::optional(chamber->air) : std::nullopt;
  const auto since_seen = memory.since_last_air + elapsed;
  memory.air.add(air);
  add_jump(limits, air, elapsed, memory);
  const Ranks ranks(sample);
  if (chamber) predict_air(limits, *chamber, since_seen, memory);
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i) {
    const auto value = known_value(sample.thermometers[i]);
    memory.thermometers[i].add(value);
    memory.thermometers[i].compare(ranks.median_without(value));
  }
  compare_rates(elapsed, memory);
}

}  // namespace gyrotherm::interlocks
