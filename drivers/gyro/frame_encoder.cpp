// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {
namespace {

/// Makes a line from tokens, with its check and terminator.
std::string join_line(const LineFormat& format, const FrameCheck& check, const std::vector<std::string>& words) {
  std::string line;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) line += i == format.header_words ? format.header_end : format.separators.substr(0, 1);
    line += words[i];
  }
  if (check.kind != CheckKind::none) {
    const auto covered =
        std::as_bytes(std::span(line)).subspan(std::min(static_cast<std::size_t>(check.from), line.size()));
    line += fmt::format("{}{:0{}x}", format.mark, compute_check_value(check, covered), 2 * byte_count(check));
  }
  return line + format.terminator;
}

/// Returns the nearest value that fits in the slice of the field.
RawValue clamp_to_slice(const FrameField& field, const RawValue& raw) {
  if (raw.is_real || field.bits >= 63) return raw;
  const auto values = std::int64_t{1} << field.bits;
  const auto lowest = is_signed(field.type) ? -values / 2 : 0;
  return {.whole = std::clamp(raw.whole, lowest, lowest + values - 1)};
}

RawValue raw_gyro_value(const FrameField& field, const GyroFrame& frame) {
  const auto axis = field.slot < frame.axes.size() ? frame.axes[field.slot] : AxisReading{};
  if (!is_real(field.type) && axis.pulses) return {.whole = *axis.pulses};
  return invert_scale(field, axis.value.value_or(0));
}

std::optional<double> find_value(const GyroFrame& frame, std::size_t slot) {
  return slot < frame.values.size() ? frame.values[slot] : std::nullopt;
}

/// Returns the raw value of a field that is not a status.
RawValue raw_value(const FrameField& field, const GyroFrame& frame) {
  if (is_gyro(field.role)) return raw_gyro_value(field, frame);
  if (is_housekeeping(field))
    return clamp_to_slice(field, invert_scale(field, find_value(frame, field.slot).value_or(0)));
  if (field.role == FieldRole::sequence) return {.whole = frame.sequence.value_or(0)};
  if (field.role != FieldRole::timestamp) return {.real = 0, .is_real = is_real(field.type)};
  const auto counts = frame.timestamp.value_or(0);
  if (!is_real(field.type)) return {.whole = static_cast<std::int64_t>(counts)};
  return invert_scale(field, static_cast<double>(counts) * field.unit_s);
}

/// Returns `present` with good bits under the masks of the status and its rules, or with bad bits under the mask of the
/// status if the frame is bad. A flagged frame breaks the first `warning` rule. Fields that share bits with a status
/// must be written after it.
RawValue status_value(const FrameField& field, const RawValue& present, const GyroFrame& frame) {
  auto status = static_cast<std::uint32_t>(present.whole);
  bool flagged = !frame.flagged;
  for (const auto& rule : field.rules) {
    const bool breaks = !flagged && rule.verdict == StatusMeaning::warning;
    status = (status & ~rule.mask) | (breaks ? ~rule.good & rule.mask : rule.good);
    flagged = flagged || breaks;
  }
  status = (status & ~field.mask) | ((frame.good ? field.good : ~field.good) & field.mask);
  return {.whole = status};
}

bool is_sent_in_frame(const FrameField& field, const GyroFrame& frame) {
  if (field.every > 1 && frame.sequence.value_or(0) % field.every != field.turn) return false;
  if (field.when_mask != 0 && is_housekeeping(field)) return find_value(frame, field.slot).has_value();
  return field.role != FieldRole::other_axis && (field.role != FieldRole::value || is_housekeeping(field));
}

/// Writes the fields of a line. Fields that are slices of one integer are combined.
class LineWriter {
 public:
  explicit LineWriter(const LineFormat& format) : words_(format.words, "0"), wholes_(format.words) {
    if (!format.starts_with.empty()) words_.front() = format.starts_with;
  }
  void write(const FrameField& field, const GyroFrame& frame) {
    const auto position = static_cast<std::size_t>(field.offset);
    auto& whole = wholes_[position];
    const bool is_hexadecimal = field.type == FieldType::hexadecimal || field.type == FieldType::signed_hexadecimal;
    const RawValue present{.whole = static_cast<std::int64_t>(whole >> field.low_bit)};
    const auto raw = field.role == FieldRole::status ? status_value(field, present, frame) : raw_value(field, frame);
    whole = replace_slice(field, whole, raw);
    words_[position] = is_hexadecimal                     ? fmt::format("{:08x}", whole)
                       : field.type == FieldType::integer ? fmt::format("{}", static_cast<std::int64_t>(whole))
                                                          : print_token(field, raw);
  }
  [[nodiscard]] const std::vector<std::string>& words() const { return words_; }

 private:
  std::vector<std::string> words_;
  std::vector<std::uint64_t> wholes_;
};

std::vector<std::byte> encode_line(const FrameFormat& format, const GyroFrame& frame) {
  LineWriter writer(*format.line);
  for (const bool statuses : {true, false})
    for (const auto& field : format.fields)
      if ((field.role == FieldRole::status) == statuses && is_sent_in_frame(field, frame)) writer.write(field, frame);
  const auto line = join_line(*format.line, format.check, writer.words());
  const auto bytes = std::as_bytes(std::span(line));
  return {bytes.begin(), bytes.end()};
}

/// Returns the number of axes and the number of housekeeping values in a message.
std::pair<std::size_t, std::size_t> count_contents(const FrameFormat& format, std::uint32_t id) {
  std::pair<std::size_t, std::size_t> content{};
  for (const auto& field : format.fields) {
    if (!is_in_message(field, id)) continue;
    content.first += is_gyro(field.role) ? 1 : 0;
    content.second += is_housekeeping(field) ? 1 : 0;
  }
  return content;
}

/// Returns the first message with the most axes and values.
std::optional<FrameVariant> fullest_variant(const FrameFormat& format) {
  if (!format.id) return std::nullopt;
  const auto fullest =
      std::max_element(format.variants.begin(), format.variants.end(), [&](const auto& one, const auto& other) {
        return count_contents(format, one.id) < count_contents(format, other.id);
      });
  if (fullest != format.variants.end()) return *fullest;
  const auto* gyro = format.gyro();
  return FrameVariant{.id = gyro && !gyro->ids.empty() ? gyro->ids.front() : 0};
}

std::vector<std::byte> encode_message(const FrameFormat& format, const std::optional<FrameVariant>& variant,
                                      const GyroFrame& frame) {
  std::vector<std::byte> bytes(variant && variant->length != 0 ? variant->length : format.length);
  std::copy(format.sync.begin(), format.sync.end(), bytes.begin());
  const auto write_head = [&](const HeadNumber& at, std::uint64_t number) {
    store_bits(std::span(bytes).subspan(at.offset, at.bytes), at.big_endian, number);
  };
  if (format.id) write_head(*format.id, variant->id);
  if (format.length_at) write_head(*format.length_at, bytes.size() - format.length_plus);
  const auto id = variant ? std::optional(variant->id) : std::nullopt;
  for (const auto& field : format.fields)
    if (is_in_message(field, id) && field.role == FieldRole::status)
      if (const auto present = read_raw(field, bytes)) write_raw(field, bytes, status_value(field, *present, frame));
  for (const auto& field : format.fields)
    if (is_in_message(field, id) && field.role != FieldRole::status && is_sent_in_frame(field, frame))
      write_raw(field, bytes, raw_value(field, frame));
  write_check(variant && variant->check ? *variant->check : format.check, bytes);
  return bytes;
}

/// Returns a value up to 255 that breaks the rule, or a good one if there is none.
std::uint32_t find_bad_value(const StatusRule& rule) {
  for (std::uint32_t value = 0; value <= 0xFF; ++value)
    if ((value & ~rule.mask) == 0 && !is_satisfied(rule, value)) return value;
  return rule.good;
}

}  // namespace

std::vector<std::byte> encode_frame(const FrameFormat& format, const GyroFrame& frame) {
  if (format.line) return encode_line(format, frame);
  return encode_message(format, fullest_variant(format), frame);
}

std::vector<std::byte> encode_settings(const FrameFormat& format, std::uint32_t id, bool differs) {
  auto changed = format;
  for (auto& field : changed.fields)
    for (auto& rule : field.rules)
      if (differs && rule.verdict == StatusMeaning::mismatch) rule.good = find_bad_value(rule);
  const auto variant = std::ranges::find(changed.variants, id, &FrameVariant::id);
  assert(variant != changed.variants.end());
  return encode_message(changed, *variant, {});
}

}  // namespace gyrotherm::drivers
