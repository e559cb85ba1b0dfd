#include <algorithm>
#include <cassert>
#include <utility>

#include "drivers/checksum.hpp"
#include "drivers/frame_format.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kTakenBytesWorthMoving = 4096;

std::uint32_t load(std::span<const std::byte> bytes, bool big_endian) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    value = value << 8 | std::to_integer<std::uint32_t>(bytes[big_endian ? i : bytes.size() - 1 - i]);
  return value;
}

void store(std::span<std::byte> bytes, bool big_endian, std::uint64_t value) {
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[big_endian ? bytes.size() - 1 - i : i] = static_cast<std::byte>(value >> 8 * i & 0xFF);
}

std::int64_t sign_extended(std::uint32_t value, std::size_t bytes) {
  const std::int64_t sign = std::int64_t{1} << (8 * bytes - 1);
  return (std::int64_t{value} ^ sign) - sign;
}

std::size_t size_of(CheckKind kind) { return kind == CheckKind::crc32 ? 4 : kind == CheckKind::crc16 ? 2 : 1; }

std::uint32_t check_value(const FrameCheck& check, std::span<const std::byte> frame) {
  const auto covered = frame.subspan(check.from, check.offset - check.from);
  const auto by_crc = [&](int width) {
    return crc({width, check.polynomial, check.initial, check.reflected, check.final_xor}, covered);
  };
  switch (check.kind) {
    case CheckKind::none: return 0;
    case CheckKind::sum8: return sum8(covered);
    case CheckKind::xor8: return xor8(covered);
    case CheckKind::crc16: return by_crc(16);
    case CheckKind::crc32: return by_crc(32);
  }
  return 0;
}

bool passes(const FrameCheck& check, std::span<const std::byte> frame) {
  if (check.kind == CheckKind::none) return true;
  return load(frame.subspan(check.offset, size_of(check.kind)), check.big_endian) == check_value(check, frame);
}

GyroFrame decode(const FrameFormat& format, std::span<const std::byte> bytes) {
  GyroFrame frame;
  for (const auto& field : format.fields) {
    const auto width = byte_count(field.type);
    const auto raw = load(bytes.subspan(field.offset, width), field.big_endian);
    switch (field.role) {
      case FieldRole::pulse_count:
      case FieldRole::increment:
        frame.pulses = is_signed(field.type) ? sign_extended(raw, width) : std::int64_t{raw};
        break;
      case FieldRole::sequence: frame.sequence = raw; break;
      case FieldRole::timestamp: frame.timestamp = raw; break;
      case FieldRole::status: frame.good = (raw & field.mask) == field.good; break;
    }
  }
  return frame;
}

std::uint64_t raw_value(const FrameField& field, const GyroFrame& frame) {
  switch (field.role) {
    case FieldRole::pulse_count:
    case FieldRole::increment: return static_cast<std::uint64_t>(frame.pulses.value_or(0));
    case FieldRole::sequence: return frame.sequence.value_or(0);
    case FieldRole::timestamp: return frame.timestamp.value_or(0);
    case FieldRole::status: return frame.good ? field.good : ~field.good & field.mask;
  }
  return 0;
}

}  // namespace

FrameDecoder::FrameDecoder(FrameFormat format) : format_(std::move(format)) {
  assert(!format_.sync.empty() && format_.sync.size() <= format_.length);
}

void FrameDecoder::feed(std::span<const std::byte> bytes) {
  if (begin_ == buffer_.size() || begin_ > kTakenBytesWorthMoving) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<GyroFrame> FrameDecoder::take() {
  for (; buffer_.size() - begin_ >= format_.length; ++begin_, ++rejected_) {
    const auto bytes = std::span<const std::byte>(buffer_).subspan(begin_, format_.length);
    if (!std::equal(format_.sync.begin(), format_.sync.end(), bytes.begin()) || !passes(format_.check, bytes)) continue;
    begin_ += format_.length;
    return decode(format_, bytes);
  }
  return std::nullopt;
}

std::vector<std::byte> encode_frame(const FrameFormat& format, const GyroFrame& frame) {
  std::vector<std::byte> bytes(format.length);
  std::copy(format.sync.begin(), format.sync.end(), bytes.begin());
  for (const auto& field : format.fields)
    store(std::span(bytes).subspan(field.offset, byte_count(field.type)), field.big_endian, raw_value(field, frame));
  const auto& check = format.check;
  if (check.kind != CheckKind::none)
    store(std::span(bytes).subspan(check.offset, size_of(check.kind)), check.big_endian, check_value(check, bytes));
  return bytes;
}

}  // namespace gyrotherm
