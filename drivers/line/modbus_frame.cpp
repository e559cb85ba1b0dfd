#include "drivers/line/modbus_frame.hpp"

#include <fmt/format.h>

#include <cassert>

namespace gyrotherm {

namespace {

// A frame is the MBAP header (transaction, protocol, length, unit) and the protocol data unit, which opens with the
// function. Modbus Messaging on TCP/IP Implementation Guide V1.0b, section 3.1.3; Modbus Application Protocol V1.1b3,
// section 6.
constexpr std::size_t kLengthAt = 4, kUnitAt = 6, kFunctionAt = 7, kBodyAt = 8;
constexpr std::size_t kExceptionSize = 9, kRequestSize = 12, kWordsAt = 13;
constexpr std::size_t kMostBytesAfterLength = 254;
constexpr std::uint16_t kMostRead = 125, kMostWritten = 123;
constexpr std::uint8_t kExceptionFlag = 0x80;

std::uint8_t byte_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::uint8_t>(bytes[at]);
}
std::uint16_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(byte_at(bytes, at) << 8 | byte_at(bytes, at + 1));
}

void put_byte(std::vector<std::byte>& bytes, std::size_t value) { bytes.push_back(static_cast<std::byte>(value)); }
void put_word(std::vector<std::byte>& bytes, std::size_t value) {
  put_byte(bytes, value >> 8 & 0xFF);
  put_byte(bytes, value & 0xFF);
}

bool is_read(ModbusFunction function) {
  return function == ModbusFunction::read_holding || function == ModbusFunction::read_input;
}

/// Header and function of a frame of `size` bytes in all.
std::vector<std::byte> begin_frame(const ModbusRequest& request, std::size_t size) {
  std::vector<std::byte> frame;
  frame.reserve(size);
  put_word(frame, request.transaction);
  put_word(frame, 0);
  put_word(frame, size - kUnitAt);
  put_byte(frame, request.unit);
  put_byte(frame, static_cast<std::uint8_t>(request.function));
  return frame;
}

const char* meaning(std::uint8_t exception) {
  switch (exception) {
    case 1: return "illegal function";
    case 2: return "illegal data address";
    case 3: return "illegal data value";
    case 4: return "server device failure";
    case 5: return "acknowledge, still at work";
    case 6: return "server device busy";
    case 8: return "memory parity error";
    case 10: return "gateway path unavailable";
    case 11: return "gateway target did not respond";
    default: return "of the vendor's own";
  }
}

tl::unexpected<Fault> wrong(const char* field, std::size_t found, std::size_t expected) {
  return failure(FaultKind::corrupted, "", fmt::format("{} of the reply is {}, expected {}", field, found, expected));
}

Result<void> check_header(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (reply.size() < kExceptionSize) return wrong("size", reply.size(), kExceptionSize);
  if (const auto found = word_at(reply, 0); found != request.transaction)
    return wrong("transaction", found, request.transaction);
  if (const auto found = word_at(reply, 2); found != 0) return wrong("protocol", found, 0);
  if (const auto found = word_at(reply, kLengthAt); found != reply.size() - kUnitAt)
    return wrong("length", found, reply.size() - kUnitAt);
  if (const auto found = byte_at(reply, kUnitAt); found != request.unit) return wrong("unit", found, request.unit);
  return {};
}

Result<std::vector<std::uint16_t>> decode_words(const ModbusRequest& request, std::span<const std::byte> reply) {
  const std::size_t bytes = 2 * std::size_t{request.count};
  if (const auto found = byte_at(reply, kBodyAt); found != bytes) return wrong("byte count", found, bytes);
  if (reply.size() != kBodyAt + 1 + bytes) return wrong("size", reply.size(), kBodyAt + 1 + bytes);
  std::vector<std::uint16_t> words(request.count);
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = word_at(reply, kBodyAt + 1 + 2 * i);
  return words;
}

Result<std::vector<std::uint16_t>> check_echo(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (reply.size() != kRequestSize) return wrong("size", reply.size(), kRequestSize);
  if (const auto found = word_at(reply, kBodyAt); found != request.address)
    return wrong("address", found, request.address);
  const bool single = request.function == ModbusFunction::write_single;
  const auto expected = single ? request.words.front() : request.count;
  if (const auto found = word_at(reply, kBodyAt + 2); found != expected)
    return wrong(single ? "value" : "count", found, expected);
  return std::vector<std::uint16_t>{};
}

tl::unexpected<Fault> answer_with(const char* exception_code) {
  return failure(FaultKind::refused, "modbus request", exception_code);
}

/// The words of a write; none for a read. Fails with refused "3" if the frame's parts do not agree.
Result<std::vector<std::uint16_t>> written_words(const ModbusRequest& request, std::span<const std::byte> frame) {
  std::vector<std::uint16_t> words;
  const std::size_t bytes = 2 * std::size_t{request.count};
  switch (request.function) {
    case ModbusFunction::read_holding:
    case ModbusFunction::read_input:
      if (frame.size() != kRequestSize || request.count < 1 || request.count > kMostRead) return answer_with("3");
      return words;
    case ModbusFunction::write_single:
      if (frame.size() != kRequestSize) return answer_with("3");
      words.push_back(word_at(frame, kBodyAt + 2));
      return words;
    case ModbusFunction::write_multiple:
      if (request.count < 1 || request.count > kMostWritten || frame.size() != kWordsAt + bytes ||
          byte_at(frame, kRequestSize) != bytes)
        return answer_with("3");
      for (std::size_t i = 0; i < request.count; ++i) words.push_back(word_at(frame, kWordsAt + 2 * i));
      return words;
  }
  return answer_with("1");
}

}  // namespace

std::vector<std::byte> encode_request(const ModbusRequest& request) {
  assert(is_read(request.function) || request.words.size() == request.count);
  const bool multiple = request.function == ModbusFunction::write_multiple;
  auto frame = begin_frame(request, multiple ? kWordsAt + 2 * request.words.size() : kRequestSize);
  put_word(frame, request.address);
  if (request.function == ModbusFunction::write_single) {
    put_word(frame, request.words.front());
    return frame;
  }
  put_word(frame, request.count);
  if (multiple) put_byte(frame, 2 * request.words.size());
  for (const auto word : request.words) put_word(frame, word);
  return frame;
}

Result<std::vector<std::uint16_t>> decode_reply(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (auto header = check_header(request, reply); !header) return failure(std::move(header.error()));
  const auto asked = static_cast<std::uint8_t>(request.function);
  const auto found = byte_at(reply, kFunctionAt);
  if (found == (asked | kExceptionFlag)) {
    if (reply.size() != kExceptionSize) return wrong("size", reply.size(), kExceptionSize);
    const auto code = byte_at(reply, kBodyAt);
    return failure(FaultKind::refused, "", fmt::format("exception {}, {}", code, meaning(code)));
  }
  if (found != asked) return wrong("function", found, asked);
  return is_read(request.function) ? decode_words(request, reply) : check_echo(request, reply);
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
  request.function = static_cast<ModbusFunction>(byte_at(frame, kFunctionAt));
  const bool known = is_read(request.function) || request.function == ModbusFunction::write_single ||
                     request.function == ModbusFunction::write_multiple;
  if (!known) return answer_with("1");
  if (frame.size() < kRequestSize) return answer_with("3");

  request.address = word_at(frame, kBodyAt);
  request.count = request.function == ModbusFunction::write_single ? std::uint16_t{1} : word_at(frame, kBodyAt + 2);
  auto words = written_words(request, frame);
  if (!words) return failure(std::move(words.error()));
  if (request.address + request.count > 0x10000) return answer_with("2");
  request.words = std::move(*words);
  return request;
}

std::vector<std::byte> encode_reply(const ModbusRequest& request, std::span<const std::uint16_t> words) {
  if (is_read(request.function)) {
    assert(words.size() == request.count);
    auto frame = begin_frame(request, kBodyAt + 1 + 2 * words.size());
    put_byte(frame, 2 * words.size());
    for (const auto word : words) put_word(frame, word);
    return frame;
  }
  auto frame = begin_frame(request, kRequestSize);
  put_word(frame, request.address);
  put_word(frame, request.function == ModbusFunction::write_single ? request.words.front() : request.count);
  return frame;
}

std::vector<std::byte> encode_exception(std::span<const std::byte> request_frame, std::uint8_t code) {
  assert(request_frame.size() > kFunctionAt);
  ModbusRequest request{.transaction = word_at(request_frame, 0), .unit = byte_at(request_frame, kUnitAt)};
  request.function = static_cast<ModbusFunction>(byte_at(request_frame, kFunctionAt) | kExceptionFlag);
  auto frame = begin_frame(request, kExceptionSize);
  put_byte(frame, code);
  return frame;
}

}  // namespace gyrotherm
