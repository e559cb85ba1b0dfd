// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/repeat_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/clock.hpp"

namespace gyrotherm::exchange {

namespace {

/// The shortest repetition that is examined.
constexpr std::size_t kMinRepeats = 30;

/// Returns the element at a fraction of the sorted order; 0 without elements.
double element_at(std::vector<double> numbers, double fraction) {
  if (numbers.empty()) return 0;
  const auto at = numbers.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(numbers.size() - 1));
  std::ranges::nth_element(numbers, at);
  return *at;
}

}  // namespace

double RepeatWatch::Step::size() const { return std::abs(to - from); }

void RepeatWatch::Block::join(const Block& next) {
  least = std::min(least, next.least);
  greatest = std::max(greatest, next.greatest);
  sum += next.sum;
  values += next.values;
  steps_sum += next.steps_sum;
  steps_squared += next.steps_squared;
  pairs += next.pairs;
  equal_pairs += next.equal_pairs;
  reversals += next.reversals;
}

void RepeatWatch::push(Duration time, std::span<const double> values) {
  if (rows_ == kBlocks * rows_of_block_) merge_blocks();
  last_ = {rows_, time};
  const std::size_t block = rows_ / rows_of_block_;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    Column& column = columns_[i];
    if (column.blocks.size() <= block) column.blocks.resize(block + 1);
    if (!std::isnan(values[i])) take(column, values[i], last_);
  }
  ++rows_;
}

/// Doubles the length of the blocks.
void RepeatWatch::merge_blocks() {
  rows_of_block_ *= 2;
  for (Column& column : columns_) {
    for (std::size_t i = 0; i < column.blocks.size() / 2; ++i) {
      column.blocks[i] = column.blocks[2 * i];
      column.blocks[i].join(column.blocks[2 * i + 1]);
    }
    column.blocks.resize(column.blocks.size() / 2);
  }
}

void RepeatWatch::take(Column& column, double value, Moment at) {
  Block& block = column.blocks.back();
  block.least = std::min(block.least, value);
  block.greatest = std::max(block.greatest, value);
  block.sum += value;
  ++block.values;
  Run& run = column.run;
  if (run.count == 0) {
    run = {.value = value, .count = 1, .first = at, .last = at};
    return;
  }
  const double step = value - run.value;
  ++block.pairs;
  block.steps_sum += step;
  block.steps_squared += step * step;
  if (column.about.is_temperature) take_step(column, value, at);
  column.spacing = at.time - run.last.time;
  if (step == 0) {
    ++block.equal_pairs;
    ++run.count;
    run.last = at;
    return;
  }
  if (step * column.last_step < 0) ++block.reversals;
  column.last_step = step;
  column.resolution = std::min(column.resolution, std::abs(step));
  run.after = value;
  keep(column, run);
  run = {.value = value, .count = 1, .first = at, .last = at, .before = run.value};
}

/// Keeps the largest steps, and counts the later values that stay near the end of each. The step over a gap is ignored.
void RepeatWatch::take_step(Column& column, double value, Moment at) {
  constexpr double kNear = 0.25;
  constexpr int kGapInSteps = 3;
  for (Step& step : column.steps)
    if (step.seen < kMinRepeats) {
      ++step.seen;
      step.stayed += std::abs(value - step.to) <= kNear * step.size() ? 1 : 0;
    }
  const Step next{.from = column.run.value, .to = value, .at = at};
  const bool is_gap = column.spacing > Duration{} && at.time - column.run.last.time > kGapInSteps * column.spacing;
  if (next.size() == 0 || is_gap) return;
  if (column.steps.size() == kSteps && next.size() <= column.steps.back().size()) return;
  const auto place = std::ranges::find_if(column.steps, [&](const Step& step) { return step.size() < next.size(); });
  column.steps.insert(place, next);
  if (column.steps.size() > kSteps) column.steps.pop_back();
}

void RepeatWatch::keep(Column& column, const Run& run) {
  if (run.count < kMinRepeats) return;
  const auto place = std::ranges::find_if(column.longest, [&](const Run& other) { return other.count < run.count; });
  column.longest.insert(place, run);
  if (column.longest.size() > kRuns) column.longest.pop_back();
}

bool RepeatWatch::overlaps(const Run& run, std::size_t block) const {
  return block * rows_of_block_ <= run.last.row && (block + 1) * rows_of_block_ > run.first.row;
}

/// Returns nothing if too few values are outside the repetition.
std::optional<RepeatWatch::Usual> RepeatWatch::usual_outside(const Column& column, const Run& run) const {
  constexpr std::size_t kMinPairs = 16;
  constexpr double kMost = 0.75, kMiddle = 0.5;
  std::vector<double> noises, steps, equal_parts, reversals;
  Block all;
  for (std::size_t i = 0; i < column.blocks.size(); ++i) {
    const Block& block = column.blocks[i];
    if (overlaps(run, i) || block.values == 0) continue;
    all.join(block);
    if (block.pairs < kMinPairs) continue;
    const auto pairs = static_cast<double>(block.pairs);
    const double mean = block.steps_sum / pairs, square = block.steps_squared / pairs;
    noises.push_back(std::sqrt(std::max(0.0, square - mean * mean) / 2));
    steps.push_back(std::sqrt(square));
    equal_parts.push_back(static_cast<double>(block.equal_pairs) / pairs);
    reversals.push_back(static_cast<double>(block.reversals) / pairs);
  }
  if (noises.size() < 3) return std::nullopt;
  return Usual{.noise = element_at(noises, kMiddle),
               .step = element_at(steps, kMiddle),
               .equal_part = element_at(equal_parts, kMost),
               .reversals = element_at(reversals, kMost),
               .values = all.values,
               .least = all.least,
               .greatest = all.greatest};
}

/// Returns the other temperature that moves most during the repetition, if the channel would have to follow by several
/// of its steps. Outside the repetition the channel follows the other temperature by the ratio of their ranges, but not
/// faster than within a quarter of the file.
std::optional<RepeatWatch::Motion> RepeatWatch::motion_during(const Column& column, const Run& run,
                                                              const Usual& usual) const {
  constexpr double kMinMotion_k = 5, kMinSteps = 5, kLongestLag = 0.25, kMaxPart = 0.8;
  const double part = to_seconds(run.last.time - run.first.time) / std::max(to_seconds(last_.time), 1e-9);
  if (!column.about.is_temperature || part > kMaxPart) return std::nullopt;
  std::optional<Motion> most;
  for (const Column& other : columns_) {
    if (other.about.name == column.about.name || !other.about.is_temperature) continue;
    Block inside, outside;
    double distance = 0, from = kNone;
    std::size_t blocks = 0;
    for (std::size_t i = 0; i < other.blocks.size(); ++i) {
      const Block& block = other.blocks[i];
      if (block.values == 0) continue;
      (overlaps(run, i) ? inside : outside).join(block);
      if (!overlaps(run, i)) continue;
      const double mean = block.sum / static_cast<double>(block.values);
      if (std::isnan(from)) from = mean;
      distance += std::abs(mean - from);
      ++blocks;
    }
    if (inside.values == 0 || outside.values == 0 || blocks < 3) continue;
    const double follows =
        std::min(1.0, (usual.greatest - usual.least) / std::max(outside.greatest - outside.least, 1e-9));
    const double expected_k = follows * distance / static_cast<double>(blocks) * std::min(1.0, part / kLongestLag);
    const double motion_k = inside.greatest - inside.least;
    if (motion_k < kMinMotion_k || expected_k < std::max(1.0, kMinSteps * column.resolution)) continue;
    if (!most || motion_k > most->greatest - most->least)
      most = Motion{other.about.name, inside.least, inside.greatest};
  }
  return most;
}

/// Returns the largest range of another temperature during the repetition.
double RepeatWatch::largest_motion(const Column& column, const Run& run) const {
  double most = 0;
  for (const Column& other : columns_) {
    if (other.about.name == column.about.name || !other.about.is_temperature) continue;
    Block inside;
    for (std::size_t i = 0; i < other.blocks.size(); ++i)
      if (overlaps(run, i)) inside.join(other.blocks[i]);
    if (inside.values > 0) most = std::max(most, inside.greatest - inside.least);
  }
  return most;
}

/// Returns whether the repetition is far longer than the others during which another temperature moves.
bool RepeatWatch::stands_out(const Column& column, const Run& run) const {
  constexpr double kMinMotion_k = 5;
  constexpr std::size_t kMinRatio = 3;
  return std::ranges::none_of(column.longest, [&](const Run& other) {
    return other.first.row != run.first.row && kMinRatio * other.count > run.count &&
           largest_motion(column, other) >= kMinMotion_k;
  });
}

/// Returns whether the noise of the channel makes the repetition improbable. A channel whose noise is much smaller than
/// its resolution may repeat a value for any time.
bool RepeatWatch::is_beyond_noise(const Column& column, const Run& run, const Usual& usual) const {
  constexpr double kMinNoise = 0.6, kFineNoise = 1.5;  // in units of the resolution
  constexpr double kChance = 1e-6, kMinEqualPart = 0.1, kMaxEqualPart = 0.995, kMinReversals = 0.2;
  constexpr std::size_t kMinRepeatsOfCoarse = 300;
  const bool is_sampled_slowly = usual.equal_part > 0.5;
  if (usual.noise < kMinNoise * column.resolution || usual.equal_part > kMaxEqualPart) return false;
  if (usual.reversals < kMinReversals && !is_sampled_slowly) return false;
  if (usual.noise < kFineNoise * column.resolution && run.count < kMinRepeatsOfCoarse) return false;
  const double chance = kChance / static_cast<double>(usual.values + run.count);
  return static_cast<double>(run.count) > std::log(chance) / std::log(std::max(usual.equal_part, kMinEqualPart));
}

/// Returns nothing if the repetition is plausible.
std::optional<RepeatWatch::Finding> RepeatWatch::judge(const Column& column, const Run& run) const {
  constexpr double kMinJump_k = 5, kJumpInSteps = 20;
  const auto usual = usual_outside(column, run);
  const bool is_regular = column.longest.size() == kRuns && 2 * column.longest.back().count > run.count;
  if (!usual || is_regular) return std::nullopt;
  auto motion = motion_during(column, run, *usual);
  if (motion && !stands_out(column, run)) motion.reset();
  const auto moving =
      motion ? fmt::format(", while {} moves from {:.4g} to {:.4g} °C", motion->name, motion->least, motion->greatest)
             : std::string();
  const auto jump_from = [&](double neighbour, const char* words) {
    const double jump = std::abs(neighbour - run.value);  // NaN without a neighbour
    const bool is_jump = column.about.is_temperature && jump >= std::max(kMinJump_k, kJumpInSteps * usual->step);
    return is_jump ? fmt::format("{} {:.6g} {}{}", words, neighbour, column.about.unit, moving) : std::string();
  };
  if (auto text = jump_from(run.before, ", after a jump from"); !text.empty()) return Finding{std::move(text), true};
  auto until = jump_from(run.after, ", until a jump to");
  if (!until.empty() && std::isnan(run.before)) return Finding{std::move(until), true};
  if (motion) return Finding{moving};
  if (is_beyond_noise(column, run, *usual))
    return Finding{fmt::format(", although its other values vary by about {:.2g} {} from row to row", usual->noise,
                               column.about.unit)};
  return until.empty() ? std::nullopt : std::optional(Finding{std::move(until)});
}

std::string RepeatWatch::describe(const Column& column, const Run& run, const Finding& finding) const {
  const WatchedChannel& about = column.about;
  std::string remedy;
  if (finding.is_error_value && about.has_missing_texts)
    remedy =
        fmt::format("missing = [\"{:.10g}\"] in [file], or valid = [LOW, HIGH] of its column, marks them as missing",
                    (run.value - about.offset) / about.scale);
  else if (finding.is_error_value)
    remedy = "valid = [LOW, HIGH] of its column in the map marks them as missing";
  else if (about.is_axis)
    remedy = "train with --clusters before or after them";
  else
    remedy = fmt::format("train with --clusters before or after them, or remove {} from the map", about.name);
  return fmt::format(
      "warning: {} repeats {:.6g} {} in {} consecutive values, from row {} ({}) to row {} ({}){}: the sensor has "
      "probably failed; {}",
      about.name, run.value, about.unit, run.count, run.first.row + 1, format_duration(run.first.time),
      run.last.row + 1, format_duration(run.last.time), finding.evidence, remedy);
}

/// Adds the steps of a temperature that are far larger than its other steps and after which it stays at its new level.
void RepeatWatch::add_jumps(const Column& column, const std::vector<Run>& reported, Notes& notes) const {
  constexpr double kMinJump_k = 10, kJumpInSteps = 20, kJumpInLargeSteps = 5, kStayedPart = 0.9;
  if (column.steps.size() < kSteps) return;
  const auto usual = usual_outside(column, {});
  if (!usual) return;
  const double least =
      std::max({kMinJump_k, kJumpInSteps * usual->step, kJumpInLargeSteps * column.steps.back().size()});
  for (const Step& step : column.steps) {
    const bool is_reported = std::ranges::any_of(
        reported, [&](const Run& run) { return step.at.row == run.first.row || step.from == run.value; });
    const bool stayed =
        step.seen == kMinRepeats && static_cast<double>(step.stayed) >= kStayedPart * static_cast<double>(kMinRepeats);
    const bool is_end_of_spike = std::ranges::any_of(column.steps, [&](const Step& other) {
      return other.at.row < step.at.row && step.at.row - other.at.row < kMinRepeats && 2 * other.size() > step.size();
    });
    if (step.size() < least || !stayed || is_reported || is_end_of_spike) continue;
    notes.push_back(fmt::format(
        "warning: {} jumps from {:.6g} to {:.6g} {} at row {} ({}) and stays there: check the sensor; valid = [LOW, "
        "HIGH] of its column in the map excludes values",
        column.about.name, step.from, step.to, column.about.unit, step.at.row + 1, format_duration(step.at.time)));
  }
}

Notes RepeatWatch::warnings() const {
  Notes notes;
  for (const Column& column : columns_) {
    Column whole = column;
    keep(whole, whole.run);
    std::vector<Run> reported;
    for (const Run& run : whole.longest)
      if (const auto finding = judge(whole, run)) {
        notes.push_back(describe(whole, run, *finding));
        reported.push_back(run);
      }
    add_jumps(column, reported, notes);
  }
  return notes;
}

}  // namespace gyrotherm::exchange
