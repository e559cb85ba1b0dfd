#include "drivers/gyro/frame_values.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm {

namespace {

constexpr double kFarthestTime = 9.2e18;  // counts, below 2^63

std::uint32_t status_of(const RawValue& raw) { return static_cast<std::uint32_t>(raw.whole); }

bool is_good(const FrameField& field, std::uint32_t status) {
  if ((status & field.mask) != field.good) return false;
  return std::none_of(field.rules.begin(), field.rules.end(), [&](const auto& rule) {
    return rule.verdict == StatusMeaning::invalid && (status & rule.mask) != rule.good;
  });
}

std::optional<std::uint64_t> timestamp_of(const FrameField& field, const RawValue& raw) {
  if (!raw.is_real) return static_cast<std::uint64_t>(raw.whole);
  const double counts = scaled(field, raw) / field.unit_s;
  if (!(counts >= 0 && counts < kFarthestTime)) return std::nullopt;
  return static_cast<std::uint64_t>(std::llround(counts));
}

void place(const FrameField& field, const RawValue& raw, double value, GyroFrame& frame) {
  switch (field.role) {
    case FieldRole::pulse_count:
    case FieldRole::increment:
    case FieldRole::rate:
    case FieldRole::integrated_angle:
      if (!raw.is_real) frame.pulses = raw.whole;
      if (std::isfinite(value)) frame.gyro = value;
      frame.good = frame.good && std::isfinite(value);
      break;
    case FieldRole::sequence: frame.sequence = static_cast<std::uint32_t>(raw.whole); break;
    case FieldRole::timestamp: frame.timestamp = timestamp_of(field, raw); break;
    case FieldRole::status: frame.good = frame.good && is_good(field, status_of(raw)); break;
    case FieldRole::temperature: frame.temperature = value; break;
    case FieldRole::value: break;
  }
}

/// What a field of this frame holds on the wire; statuses are good ones, or bad ones.
RawValue raw_value(const FrameField& field, const GyroFrame& frame) {
  switch (field.role) {
    case FieldRole::pulse_count:
    case FieldRole::increment:
    case FieldRole::rate:
    case FieldRole::integrated_angle:
      if (!is_real(field.type) && frame.pulses) return {.whole = *frame.pulses};
      return unscaled(field, frame.gyro.value_or(0));
    case FieldRole::sequence: return {.whole = frame.sequence.value_or(0)};
    case FieldRole::timestamp:
      if (!is_real(field.type)) return {.whole = static_cast<std::int64_t>(frame.timestamp.value_or(0))};
      return unscaled(field, static_cast<double>(frame.timestamp.value_or(0)) * field.unit_s);
    case FieldRole::temperature: return unscaled(field, frame.temperature.value_or(0));
    case FieldRole::status:
    case FieldRole::value: return {.real = 0, .is_real = is_real(field.type)};
  }
  return {};
}

/// Bits of a status under its masks; the others keep what they hold.
RawValue status_value(const FrameField& field, const RawValue& present, bool good) {
  auto status = status_of(present);
  for (const auto& rule : field.rules) status = (status & ~rule.mask) | rule.good;
  status = (status & ~field.mask) | ((good ? field.good : ~field.good) & field.mask);
  return {.whole = status};
}

std::vector<std::byte> encode_line(const FrameFormat& format, const GyroFrame& frame) {
  std::vector<std::string> words(format.line->words, "0");
  if (!format.line->starts_with.empty()) words.front() = format.line->starts_with;
  for (const auto& field : format.fields) {
    auto& word = words[static_cast<std::size_t>(field.offset)];
    const bool status = field.role == FieldRole::status;
    word = print_word(field, status ? status_value(field, {}, frame.good) : raw_value(field, frame));
  }
  const auto line = join_line(*format.line, format.check, words);
  const auto bytes = std::as_bytes(std::span(line));
  return {bytes.begin(), bytes.end()};
}

/// The first message that has the gyro's field.
std::optional<FrameVariant> gyro_variant(const FrameFormat& format) {
  for (const auto& variant : format.variants)
    if (!format.gyro() || has_field(*format.gyro(), variant.id)) return variant;
  if (!format.id) return std::nullopt;
  const auto* gyro = format.gyro();
  return FrameVariant{.id = gyro && !gyro->ids.empty() ? gyro->ids.front() : 0};
}

}  // namespace

bool has_field(const FrameField& field, std::optional<std::uint32_t> id) {
  return field.ids.empty() || (id && std::find(field.ids.begin(), field.ids.end(), *id) != field.ids.end());
}

std::optional<RawValue> raw_of(const FrameField& field, const FrameView& view) {
  if (!has_field(field, view.id)) return std::nullopt;
  if (!is_word(field.type)) return read_raw(field, view.bytes);
  const auto word = static_cast<std::size_t>(field.offset);
  return word < view.words.size() ? parse_word(field, view.words[word]) : std::nullopt;
}

std::optional<std::uint32_t> sequence_of(const FrameFormat& format, const FrameView& view) {
  for (const auto& field : format.fields)
    if (field.role == FieldRole::sequence)
      if (const auto raw = raw_of(field, view)) return static_cast<std::uint32_t>(raw->whole);
  return std::nullopt;
}

bool is_refuted(const FrameFormat& format, const FrameView& view) {
  for (const auto& field : format.fields) {
    const auto raw = raw_of(field, view);
    if (!raw && is_word(field.type)) return true;
    if (!raw || field.role != FieldRole::status) continue;
    for (const auto& rule : field.rules)
      if (rule.verdict == StatusMeaning::reject && (status_of(*raw) & rule.mask) != rule.good) return true;
  }
  return false;
}

GyroFrame decode_frame(const FrameFormat& format, const FrameView& view, std::vector<std::optional<double>>& values) {
  GyroFrame frame;
  const auto sequence = sequence_of(format, view);
  values.assign(format.fields.size(), std::nullopt);
  for (std::size_t i = 0; i < format.fields.size(); ++i) {
    const auto& field = format.fields[i];
    if (field.every > 1 && (!sequence || *sequence % field.every != field.turn)) continue;
    const auto raw = raw_of(field, view);
    if (!raw) continue;
    values[i] = field.role == FieldRole::status ? raw->number(is_signed(field.type)) : scaled(field, *raw);
    place(field, *raw, *values[i], frame);
  }
  return frame;
}

std::vector<std::byte> encode_frame(const FrameFormat& format, const GyroFrame& frame) {
  if (format.line) return encode_line(format, frame);
  const auto variant = gyro_variant(format);
  std::vector<std::byte> bytes(variant && variant->length != 0 ? variant->length : format.length);
  std::copy(format.sync.begin(), format.sync.end(), bytes.begin());
  const auto head = [&](const HeadNumber& at, std::uint64_t number) {
    store_bits(std::span(bytes).subspan(at.offset, at.bytes), at.big_endian, number);
  };
  if (format.id) head(*format.id, variant->id);
  if (format.length_at) head(*format.length_at, bytes.size() - format.length_plus);
  const auto id = variant ? std::optional(variant->id) : std::nullopt;
  for (const auto& field : format.fields)
    if (has_field(field, id) && field.role != FieldRole::status && field.role != FieldRole::value)
      write_raw(field, bytes, raw_value(field, frame));
  for (const auto& field : format.fields)
    if (has_field(field, id) && field.role == FieldRole::status)
      if (const auto present = read_raw(field, bytes))
        write_raw(field, bytes, status_value(field, *present, frame.good));
  seal(variant && variant->check ? *variant->check : format.check, bytes);
  return bytes;
}

}  // namespace gyrotherm
