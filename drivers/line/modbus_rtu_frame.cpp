#include "drivers/line/modbus_rtu_frame.hpp"

#include <cassert>
#include <utility>

#include "drivers/checksum.hpp"

namespace gyrotherm {

namespace {

constexpr Crc kCrc{.width = 16, .polynomial = 0x8005, .initial = 0xFFFF, .reflected = true};
constexpr std::size_t kAround = 3;  ///< bytes of unit and CRC
constexpr std::size_t kLeast = kAround + 1;

std::uint32_t crc_of(std::span<const std::byte> bytes) { return crc(kCrc, bytes); }

std::vector<std::byte> begin_frame(std::uint8_t unit) {
  std::vector<std::byte> frame;
  frame.reserve(16);
  append_byte(frame, unit);
  return frame;
}

std::vector<std::byte> with_crc(std::vector<std::byte> frame) {
  append_rtu_crc(frame);
  return frame;
}

/// The CRC's bytes as they stand at the end of `frame`.
bool crc_fits(std::span<const std::byte> frame) {
  const auto last = frame.size() - 2;
  return crc_of(frame.first(last)) == (byte_at(frame, last) | unsigned{byte_at(frame, last + 1)} << 8);
}

std::span<const std::byte> pdu(std::span<const std::byte> frame) { return frame.subspan(1, frame.size() - kAround); }

}  // namespace

void append_rtu_crc(std::vector<std::byte>& frame) {
  const auto value = crc_of(frame);
  append_byte(frame, value & 0xFF);
  append_byte(frame, value >> 8);
}

std::vector<std::byte> encode_rtu_request(const ModbusRequest& request) {
  auto frame = begin_frame(request.unit);
  append_request(request, frame);
  return with_crc(std::move(frame));
}

Result<std::optional<std::size_t>> rtu_answer_size(const ModbusRequest& request, std::span<const std::byte> bytes) {
  if (!bytes.empty() && byte_at(bytes, 0) != request.unit) return wrong_field("unit", byte_at(bytes, 0), request.unit);
  if (bytes.size() < 2) return std::nullopt;
  const auto function = byte_at(bytes, 1);
  if (answers_by_exception(request, function)) return kAround + kExceptionReplySize;
  if (!answers(request, function))
    return wrong_field("function", function, static_cast<std::uint8_t>(request.function));
  const auto size = kAround + reply_size(request);
  if (reads(request.function) && bytes.size() > 2 && byte_at(bytes, 2) + kAround + 2u != size)
    return wrong_field("byte count", byte_at(bytes, 2), size - kAround - 2);
  return size;
}

Result<ModbusAnswer> decode_rtu_answer(const ModbusRequest& request, std::span<const std::byte> frame) {
  const auto size = rtu_answer_size(request, frame);
  if (!size) return failure(size.error());
  const auto expected = size->value_or(kAround + kExceptionReplySize);
  if (frame.size() != expected) return wrong_field("size", frame.size(), expected);
  if (!crc_fits(frame)) return failure(FaultKind::corrupted, "", "the CRC of the reply does not fit");
  return decode_answer_of(request, pdu(frame));
}

Result<std::optional<std::size_t>> rtu_request_size(std::span<const std::byte> bytes) {
  const auto size = bytes.empty() ? std::nullopt : request_size(bytes.subspan(1));
  if (!size) return std::nullopt;
  if (*size == 0) return failure(FaultKind::corrupted, "modbus request", "an unknown function");
  return bytes.size() < kAround + *size ? std::nullopt : std::optional(kAround + *size);
}

Result<ModbusRequest> decode_rtu_request(std::span<const std::byte> frame) {
  if (frame.size() < kLeast || frame.size() > kLongestRtuFrame)
    return failure(FaultKind::corrupted, "modbus request", "not one whole frame");
  if (!crc_fits(frame)) return failure(FaultKind::corrupted, "modbus request", "the CRC does not fit");
  ModbusRequest request{.unit = byte_at(frame, 0)};
  if (auto decoded = decode_request_into(request, pdu(frame)); !decoded) return failure(std::move(decoded.error()));
  return request;
}

std::vector<std::byte> encode_rtu_reply(const ModbusRequest& request, std::span<const std::uint16_t> words) {
  auto frame = begin_frame(request.unit);
  append_reply(request, words, frame);
  return with_crc(std::move(frame));
}

std::vector<std::byte> encode_rtu_exception(std::span<const std::byte> request_frame, std::uint8_t code) {
  assert(request_frame.size() >= 2);
  auto frame = begin_frame(byte_at(request_frame, 0));
  append_exception(request_frame[1], code, frame);
  return with_crc(std::move(frame));
}

}  // namespace gyrotherm
