#include "simulator/servers/stream_writer.hpp"

#include <cassert>
#include <cmath>
#include <utility>

namespace gyrotherm {
namespace {

/// What the other end reads where `value` was sent.
double as_sent(const FrameField& field, double value) {
  const auto raw = unscaled(field, value);
  if (is_word(field.type)) {
    const auto read = parse_word(field, print_word(field, raw));
    return read ? scaled(field, *read) : value;
  }
  if (field.type == FieldType::f32) return scaled(field, {.real = static_cast<float>(raw.real), .is_real = true});
  return scaled(field, raw);
}

double wrapped(double angle, double wraps_at) { return angle - wraps_at * std::floor(angle / wraps_at); }

bool is_counted(const FrameField& field) {
  return !is_real(field.type) && field.zero == 0 &&
         (field.role == FieldRole::pulse_count || field.role == FieldRole::increment);
}

}  // namespace

FrameFormat at_one_frame_a_second(FrameFormat format) {
  if (format.rate_hz > 0) format.rate_hz = 1;
  return format;
}

StreamWriter::StreamWriter(FrameFormat format, double arcsec_per_pulse)
    : format_(std::move(format)), arcsec_per_pulse_(arcsec_per_pulse) {
  assert(format_.gyro() != nullptr);
}

/// Of the frame numbered `number`, which may be before the first.
std::uint32_t StreamWriter::sequence(std::int64_t number) const {
  const auto* field = format_.find(FieldRole::sequence);
  const auto steps = number * static_cast<std::int64_t>(field ? field->step : 1);
  const auto range = static_cast<std::int64_t>(field && field->range != 0 ? field->range : 1ull << 32);
  return static_cast<std::uint32_t>((steps % range + range) % range);
}

GyroFrame StreamWriter::frame(std::int64_t number, std::int64_t device_time_us) const {
  GyroFrame frame{.sequence = sequence(number)};
  const auto* time = format_.find(FieldRole::timestamp);
  const double unit_us = time ? time->unit_s * 1e6 : 1;
  frame.timestamp = static_cast<std::uint64_t>(std::llround(static_cast<double>(device_time_us) / unit_us));
  frame.gyro = 0;
  if (!is_real(format_.gyro()->type)) frame.pulses = unscaled(*format_.gyro(), 0).whole;
  frame.temperature = 25;
  return frame;
}

std::vector<std::byte> StreamWriter::lead_in() const {
  if (format_.line) {
    const auto bytes = std::as_bytes(std::span(format_.line->terminator));
    return {bytes.begin(), bytes.end()};
  }
  std::vector<std::byte> bytes;
  for (auto before = static_cast<std::int64_t>(format_.lock_frames); before > 0; --before) {
    const auto one = encode_frame(format_, frame(number_ - before, 0));
    bytes.insert(bytes.end(), one.begin(), one.end());
    bytes.insert(bytes.end(), format_.tail.begin(), format_.tail.end());
  }
  return bytes;
}

/// Whole counts, or whole parts of an angle.
void StreamWriter::put_counts(double pulses, GyroFrame& frame) {
  const auto& field = *format_.gyro();
  const auto unit = arcsec_per(field.unit, field.role);
  const double counts = unit ? pulses * arcsec_per_pulse_ / field.scale.of(*unit) : pulses;
  const auto total = static_cast<std::int64_t>(std::floor(counts));
  frame.pulses = field.role == FieldRole::increment ? total - sent_counts_ : total;
  sent_counts_ = total;
}

void StreamWriter::put_angle(double pulses, double seconds, GyroFrame& frame) {
  const auto& field = *format_.gyro();
  const double angle = pulses * arcsec_per_pulse_ / arcsec_per(field.unit, field.role).value_or(1);
  double value = field.role == FieldRole::rate ? (angle - sent_) / seconds : angle - sent_;
  if (field.role == FieldRole::integrated_angle) value = field.wraps_at > 0 ? wrapped(angle, field.wraps_at) : angle;
  const double read = as_sent(field, value);
  if (field.role == FieldRole::rate) sent_ += read * seconds;
  if (field.role == FieldRole::increment) sent_ += read;
  frame.gyro = value;
  if (!is_real(field.type)) frame.pulses = unscaled(field, value).whole;
}

std::vector<std::byte> StreamWriter::next(double pulses, std::int64_t device_time_us, double seconds) {
  auto one = frame(number_++, device_time_us);
  if (is_counted(*format_.gyro()))
    put_counts(pulses, one);
  else
    put_angle(pulses, seconds, one);
  auto bytes = encode_frame(format_, one);
  bytes.insert(bytes.end(), format_.tail.begin(), format_.tail.end());
  return bytes;
}

void StreamWriter::skip(double pulses) {
  const auto& field = *format_.gyro();
  ++number_;
  GyroFrame nobody;
  if (is_counted(field))
    put_counts(pulses, nobody);
  else
    sent_ = pulses * arcsec_per_pulse_ / arcsec_per(field.unit, field.role).value_or(1);
}

}  // namespace gyrotherm
