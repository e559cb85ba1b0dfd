// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_sum.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm::drivers {

namespace {

constexpr double kArcsecPerCount = 1e-6;  // of what is no integer
constexpr double kFarthestCount = 9.2e18, kMostSeconds = 1e6;

/// How far a counter of `range` values (0: 2^64) went from `before` to `now`.
std::uint64_t forward(std::uint64_t before, std::uint64_t now, std::uint64_t range) {
  if (range == 0) return now - before;
  return (now % range + range - before % range) % range;
}

/// The same for an up–down counter: the shorter way round.
std::int64_t signed_step(std::int64_t before, std::int64_t now, std::uint64_t range) {
  const auto difference = static_cast<std::uint64_t>(now) - static_cast<std::uint64_t>(before);
  if (range == 0) return static_cast<std::int64_t>(difference);
  auto step = static_cast<std::int64_t>(difference) % static_cast<std::int64_t>(range);
  if (step < 0) step += static_cast<std::int64_t>(range);
  return step - (static_cast<std::uint64_t>(step) < range / 2 ? 0 : static_cast<std::int64_t>(range));
}

double wrapped(double step, double wraps_at) { return step - wraps_at * std::round(step / wraps_at); }

Duration seconds_of(double seconds) { return from_seconds(std::min(seconds, kMostSeconds)); }

}  // namespace

std::optional<double> arcsec_per_count(const FrameFormat& format) {
  const auto& field = *format.gyro();
  if (!is_counted(field)) return kArcsecPerCount;
  const auto unit = arcsec_per(field.unit, field.role);
  if (!unit) return std::nullopt;
  return field.scale.of(*unit);
}

std::uint64_t FrameSum::frames_since(std::uint32_t sequence) const {
  const auto* field = format_.find(FieldRole::sequence);
  return forward(sequence, *sequence_, field->range) / field->step;
}

void FrameSum::add(const GyroFrame& frame, FrameTally& tally) {
  tally.bad += frame.good ? 0 : 1;
  const auto before = sequence_;
  if (frame.sequence) sequence_ = frame.sequence;
  if (frame.sequence && before) {
    const auto* field = format_.find(FieldRole::sequence);
    tally.lost += forward(*before + field->step, *frame.sequence, field->range) / field->step;
  }
  if (frame.pulses || frame.gyro) add_gyro(frame, tally);
}

void FrameSum::add_gyro(const GyroFrame& frame, FrameTally& tally) {
  const auto& field = *format_.gyro();
  const bool first = !origin_;
  origin_ = true;
  const double value = frame.gyro.value_or(0);
  const auto pulses = frame.pulses.value_or(0);
  if (!first) {
    ++tally.frames;
    const double arcsec = value * arcsec_per(field.unit, field.role).value_or(0);
    if (field.role == FieldRole::rate) tally.arcsec_per_s += arcsec;
    if (field.role == FieldRole::increment && is_counted(field)) tally.counts += pulses;
    if (field.role == FieldRole::increment && !is_counted(field)) tally.arcsec += arcsec;
    if (field.role == FieldRole::pulse_count && pulses_) tally.counts += signed_step(*pulses_, pulses, field.range);
    if (field.role == FieldRole::integrated_angle && angle_)
      tally.arcsec += wrapped(value - *angle_, field.wraps_at) * *arcsec_per(field.unit, field.role);
  }
  const auto* time = format_.find(FieldRole::timestamp);
  tally.frame = Duration::zero();
  if (format_.clocked_by_sequence && gyro_sequence_ && sequence_)
    tally.frame = seconds_of(static_cast<double>(frames_since(*gyro_sequence_)) / format_.rate_hz);
  else if (!format_.clocked_by_sequence && time && timestamp_ && frame.timestamp)
    tally.frame = seconds_of(static_cast<double>(forward(*timestamp_, *frame.timestamp, time->range)) * time->unit_s);
  tally.interval += tally.frame;
  if (format_.rate_hz > 0 && !format_.find(FieldRole::sequence) && tally.frame > Duration::zero())
    tally.lost += static_cast<std::uint64_t>(
        std::max<std::int64_t>(0, std::llround(to_seconds(tally.frame) * format_.rate_hz) - 1));
  gyro_sequence_ = sequence_;
  timestamp_ = frame.timestamp;
  pulses_ = pulses;
  angle_ = value;
}

std::int64_t FrameSum::counts(const FrameTally& tally, Duration interval) const {
  const auto& field = *format_.gyro();
  if (is_counted(field)) return tally.counts;
  double arcsec = tally.arcsec;
  if (field.role == FieldRole::rate && tally.frames > 0)
    arcsec = tally.arcsec_per_s / static_cast<double>(tally.frames) * to_seconds(interval);
  return std::llround(std::clamp(arcsec / kArcsecPerCount, -kFarthestCount, kFarthestCount));
}

}  // namespace gyrotherm::drivers
