#include "drivers/line/modbus_frame.hpp"

#include <cassert>
#include <utility>

namespace gyrotherm {

namespace {

// The header is transaction, protocol, length and unit; the protocol data unit follows.
constexpr std::size_t kLengthAt = 4, kUnitAt = 6, kFunctionAt = 7;
constexpr std::size_t kExceptionSize = kFunctionAt + kExceptionReplySize;
constexpr std::size_t kMostBytesAfterLength = 254;
constexpr std::size_t kUsualSize = 16;

std::vector<std::byte> begin_frame(std::uint16_t transaction, std::uint8_t unit) {
  std::vector<std::byte> frame;
  frame.reserve(kUsualSize);
  append_word(frame, transaction);
  append_word(frame, 0);
  append_word(frame, 0);
  append_byte(frame, unit);
  return frame;
}

std::vector<std::byte> with_length(std::vector<std::byte> frame) {
  const auto length = frame.size() - kUnitAt;
  frame[kLengthAt] = static_cast<std::byte>(length >> 8);
  frame[kLengthAt + 1] = static_cast<std::byte>(length & 0xFF);
  return frame;
}

Result<void> check_header(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (reply.size() < kExceptionSize) return wrong_field("size", reply.size(), kExceptionSize);
  if (const auto found = word_at(reply, 0); found != request.transaction)
    return wrong_field("transaction", found, request.transaction);
  if (const auto found = word_at(reply, 2); found != 0) return wrong_field("protocol", found, 0);
  if (const auto found = word_at(reply, kLengthAt); found != reply.size() - kUnitAt)
    return wrong_field("length", found, reply.size() - kUnitAt);
  if (const auto found = byte_at(reply, kUnitAt); found != request.unit)
    return wrong_field("unit", found, request.unit);
  return {};
}

}  // namespace

std::vector<std::byte> encode_request(const ModbusRequest& request) {
  auto frame = begin_frame(request.transaction, request.unit);
  append_request(request, frame);
  return with_length(std::move(frame));
}

Result<ModbusAnswer> decode_answer(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (auto header = check_header(request, reply); !header) return failure(std::move(header.error()));
  return decode_answer_of(request, reply.subspan(kFunctionAt));
}

Result<std::vector<std::uint16_t>> decode_reply(const ModbusRequest& request, std::span<const std::byte> reply) {
  return decode_answer(request, reply).and_then(words_of);
}

Result<std::optional<std::size_t>> frame_length(std::span<const std::byte> bytes) {
  if (bytes.size() < kUnitAt) return std::nullopt;
  const std::size_t after = word_at(bytes, kLengthAt);
  if (word_at(bytes, 2) != 0 || after < 2 || after > kMostBytesAfterLength)
    return failure(FaultKind::corrupted, "modbus request", "not a Modbus TCP header");
  const auto size = kUnitAt + after;
  return bytes.size() < size ? std::nullopt : std::optional(size);
}

Result<ModbusRequest> decode_request(std::span<const std::byte> frame) {
  const auto length = frame_length(frame);
  if (!length) return failure(length.error());
  if (*length != frame.size()) return failure(FaultKind::corrupted, "modbus request", "not one whole frame");

  ModbusRequest request{.transaction = word_at(frame, 0), .unit = byte_at(frame, kUnitAt)};
  if (auto decoded = decode_request_into(request, frame.subspan(kFunctionAt)); !decoded)
    return failure(std::move(decoded.error()));
  return request;
}

std::vector<std::byte> encode_reply(const ModbusRequest& request, std::span<const std::uint16_t> words) {
  auto frame = begin_frame(request.transaction, request.unit);
  append_reply(request, words, frame);
  return with_length(std::move(frame));
}

std::vector<std::byte> encode_exception(std::span<const std::byte> request_frame, std::uint8_t code) {
  assert(request_frame.size() > kFunctionAt);
  auto frame = begin_frame(word_at(request_frame, 0), byte_at(request_frame, kUnitAt));
  append_exception(request_frame[kFunctionAt], code, frame);
  return with_length(std::move(frame));
}

}  // namespace gyrotherm
