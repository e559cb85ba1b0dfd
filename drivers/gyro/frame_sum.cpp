// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_sum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrotherm::drivers {

namespace {

constexpr double kArcsecPerCount = 1e-6;  // for fields that are not integers
constexpr double kMaxCount = 9.2e18, kMostSeconds = 1e6;
/// Least range of a sequence in which a forward step of more than half the range is taken as a backward step.
constexpr std::uint64_t kWideSequence = 1 << 16;

/// Returns the forward distance between two states of a counter that has `range` values; 0 means 2^64.
std::uint64_t forward_distance(std::uint64_t before, std::uint64_t now, std::uint64_t range) {
  if (range == 0) return now - before;
  return (now % range + range - before % range) % range;
}

/// Returns the signed distance between two states of an up–down counter, in the shorter direction.
std::int64_t signed_step(std::int64_t before, std::int64_t now, std::uint64_t range) {
  const auto difference = static_cast<std::uint64_t>(now) - static_cast<std::uint64_t>(before);
  if (range == 0) return static_cast<std::int64_t>(difference);
  auto step = static_cast<std::int64_t>(difference) % static_cast<std::int64_t>(range);
  if (step < 0) step += static_cast<std::int64_t>(range);
  return step - (static_cast<std::uint64_t>(step) < range / 2 ? 0 : static_cast<std::int64_t>(range));
}

double wrap_step(double step, double wraps_at) { return step - wraps_at * std::round(step / wraps_at); }

Duration capped_duration(double seconds) { return from_seconds(std::min(seconds, kMostSeconds)); }

}  // namespace

std::optional<double> arcsec_per_count(const FrameFormat& format, std::size_t axis) {
  const auto& field = *format.gyros()[axis];
  if (!is_counted(field)) return kArcsecPerCount;
  const auto unit = arcsec_per(field.unit, field.role);
  if (!unit) return std::nullopt;
  return field.scale.of(*unit);
}

void StepWatch::add(double step) {
  constexpr double kScatter = 0.2;
  const bool agrees = run_length_ > 0 && std::abs(step - step_) <= (is_exact_ ? 0 : kScatter * step_);
  if (!agrees) step_ = step;
  run_length_ = agrees ? run_length_ + 1 : 1;
  ++step_count_;
}

/// Returns whether the step differs from the described one. For time stamps, it differs above 1.25 or below 0.8, where
/// lost frames would be miscounted.
bool StepWatch::is_deviating() const { return step_ > 0 && (is_exact_ ? step_ != 1 : step_ > 1.25 || step_ < 0.8); }

std::optional<double> StepWatch::find_deviating_step() const {
  constexpr std::uint64_t kMinRunLength = 8, kMinRunLengthAtStart = 3;
  const bool is_steady =
      run_length_ >= kMinRunLength || (run_length_ >= kMinRunLengthAtStart && run_length_ == step_count_);
  return is_steady && is_deviating() ? std::optional(step_) : std::nullopt;
}

FrameSum::FrameSum(const FrameFormat& format)
    : clocked_by_sequence_(format.clocked_by_sequence),
      rate_hz_(format.rate_hz),
      steps_(format.find(FieldRole::sequence) != nullptr) {
  for (const auto* field : format.gyros())
    axes_.push_back({.role = field->role,
                     .is_counted = is_counted(*field),
                     .range = field->range,
                     .wraps_at = field->wraps_at,
                     .arcsec_per_unit = arcsec_per(field->unit, field->role).value_or(0)});
  if (const auto* field = format.find(FieldRole::sequence)) sequence_format_ = {field->range, field->step};
  if (const auto* field = format.find(FieldRole::timestamp))
    time_ = {field->range, field->unit_s, is_real(field->type)};
}

void FrameSum::add(const GyroFrame& frame, FrameTally& tally) {
  tally.axes.resize(axes_.size());
  tally.bad += frame.good ? 0 : 1;
  if (frame.sequence) update_losses(*frame.sequence, tally);
  if (frame.sequence) sequence_ = frame.sequence;
  if (frame.timestamp) timestamp_ = frame.timestamp;
  has_new_time_ = has_new_time_ || frame.timestamp;
  bool whole = true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (i < frame.axes.size()) add_reading(frame.axes[i], !frame.good, axes_[i]);
    whole = whole && axes_[i].pending.frames > 0;
  }
  if (whole) end_round(tally);
}

/// Counts lost frames by the sequence. After a backward step their number is unknown.
void FrameSum::update_losses(std::uint32_t sequence, FrameTally& tally) {
  if (!sequence_ || !sequence_format_) return;
  const auto [range, step] = *sequence_format_;
  const auto distance = forward_distance(*sequence_, sequence, range);
  steps_.add(static_cast<double>(distance) / static_cast<double>(step));
  const bool is_wide = range == 0 || range >= kWideSequence;
  if (distance == 0 || (is_wide && distance > (range == 0 ? ~std::uint64_t{0} : range) / 2))
    tally.is_disordered = true;
  else
    tally.lost += forward_distance(*sequence_ + step, sequence, range) / step;
}

void FrameSum::add_reading(const AxisReading& reading, bool is_bad, Axis& axis) {
  if (!reading.pulses && !reading.value) return;
  const double value = reading.value.value_or(0);
  const auto pulses = reading.pulses.value_or(0);
  auto& pending = axis.pending;
  ++pending.frames;
  switch (axis.role) {
    case FieldRole::rate: pending.arcsec_per_s += value * axis.arcsec_per_unit; break;
    case FieldRole::increment:
      if (axis.is_counted)
        pending.counts += pulses;
      else
        pending.arcsec += value * axis.arcsec_per_unit;
      break;
    case FieldRole::pulse_count:
      if (axis.pulses) pending.counts += signed_step(*axis.pulses, pulses, axis.range);
      break;
    case FieldRole::integrated_angle:
      if (axis.angle) pending.arcsec += wrap_step(value - *axis.angle, axis.wraps_at) * axis.arcsec_per_unit;
      break;
    default: break;
  }
  axis.pulses = pulses;
  axis.angle = value;
  axis.is_bad = is_bad;
}

bool FrameSum::has_bad_reference() const {
  return std::ranges::any_of(axes_, [](const Axis& axis) {
    return axis.is_bad && (axis.role == FieldRole::pulse_count || axis.role == FieldRole::integrated_angle);
  });
}

Duration FrameSum::since_last_round() const {
  if (clocked_by_sequence_ && round_sequence_ && sequence_ && sequence_format_) {
    const auto frames =
        forward_distance(*round_sequence_, *sequence_, sequence_format_->range) / sequence_format_->step;
    return capped_duration(static_cast<double>(frames) / rate_hz_);
  }
  if (!clocked_by_sequence_ && time_ && round_timestamp_ && timestamp_)
    return capped_duration(static_cast<double>(forward_distance(*round_timestamp_, *timestamp_, time_->range)) *
                           time_->unit_s);
  return Duration::zero();
}

/// Returns whether the device's time must differ from frame to frame. This is checked only without a sequence, and if
/// the resolution of the time is finer than half the time between frames.
bool FrameSum::has_time_per_frame() const {
  return rate_hz_ > 0 && !sequence_format_ && time_ && !time_->is_real && 2 * rate_hz_ * time_->unit_s < 1;
}

void FrameSum::end_round(FrameTally& tally) {
  const bool dropped = std::exchange(is_round_dropped_, false);
  const bool counts = std::exchange(has_origin_, true) && !dropped;
  tally.round = counts ? since_last_round() : Duration::zero();
  tally.interval += tally.round;
  tally.longest = std::max(tally.longest, tally.round);
  tally.rounds += counts ? 1 : 0;
  const bool is_time_unchanged =
      std::exchange(has_new_time_, false) && round_timestamp_ && tally.round == Duration::zero();
  if (counts && is_time_unchanged && has_time_per_frame()) tally.is_disordered = true;
  if (rate_hz_ > 0 && !sequence_format_ && tally.round > Duration::zero()) {
    steps_.add(to_seconds(tally.round) * rate_hz_);
    tally.lost +=
        static_cast<std::uint64_t>(std::max<std::int64_t>(0, std::llround(to_seconds(tally.round) * rate_hz_) - 1));
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto pending = std::exchange(axes_[i].pending, {});
    if (!counts) continue;
    auto& axis = tally.axes[i];
    axis.frames += pending.frames;
    axis.counts += pending.counts;
    axis.arcsec += pending.arcsec;
    axis.arcsec_per_s += pending.arcsec_per_s;
  }
  round_sequence_ = sequence_;
  round_timestamp_ = timestamp_;
}

void FrameSum::drop_round() {
  for (auto& axis : axes_) {
    is_round_dropped_ = is_round_dropped_ || axis.pending.frames > 0;
    axis.pending = {};
  }
}

std::vector<std::int64_t> FrameSum::counts(const FrameTally& tally, Duration interval) const {
  std::vector<std::int64_t> all(axes_.size());
  for (std::size_t i = 0; i < std::min(all.size(), tally.axes.size()); ++i) {
    const auto& axis = tally.axes[i];
    double arcsec = axis.arcsec;
    if (axes_[i].role == FieldRole::rate && axis.frames > 0)
      arcsec = axis.arcsec_per_s / static_cast<double>(axis.frames) * to_seconds(interval);
    all[i] =
        axes_[i].is_counted ? axis.counts : std::llround(std::clamp(arcsec / kArcsecPerCount, -kMaxCount, kMaxCount));
  }
  return all;
}

void FrameMeans::add(const GyroFrame& frame) {
  flagged_ += frame.flagged ? 1 : 0;
  if (!frame.good) return;
  bool averaged = false;
  for (std::size_t i = 0; i < std::min(sums_.size(), frame.values.size()); ++i) {
    if (!frame.values[i]) continue;
    sums_[i].sum += *frame.values[i];
    ++sums_[i].frames;
    averaged = true;
  }
  frames_ += averaged ? 1 : 0;
}

std::vector<double> FrameMeans::values() const {
  if (sums_.empty()) return {};
  std::vector<double> found;
  found.reserve(sums_.size() + 2);
  for (const auto& [sum, frames] : sums_)
    found.push_back(frames == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(frames));
  found.push_back(static_cast<double>(frames_));
  found.push_back(static_cast<double>(flagged_));
  return found;
}

void FrameMeans::clear() {
  std::fill(sums_.begin(), sums_.end(), Sum{});
  frames_ = flagged_ = 0;
}

}  // namespace gyrotherm::drivers
