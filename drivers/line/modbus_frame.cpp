// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/modbus_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "drivers/checksum.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kShortRequest = 5;  ///< bytes: function, address, last field
constexpr std::size_t kWordsAt = 6;
constexpr std::uint16_t kMostRead = 125, kMostWritten = 123;
constexpr std::uint8_t kExceptionFlag = 0x80;
constexpr std::uint16_t kCoilOn = 0xFF00;
constexpr std::size_t kExceptionReplySize = 2;

void append_byte(std::vector<std::byte>& bytes, std::size_t value) { bytes.push_back(static_cast<std::byte>(value)); }
void append_word(std::vector<std::byte>& bytes, std::size_t value) {
  append_byte(bytes, value >> 8 & 0xFF);
  append_byte(bytes, value & 0xFF);
}

/// Returns the fault for a field of a reply with an unexpected value.
tl::unexpected<Fault> field_fault(const char* field, std::size_t found, std::size_t expected) {
  return failure(FaultKind::corrupted, "", fmt::format("{} of the reply is {}, expected {}", field, found, expected));
}

std::uint8_t function_code(ModbusFunction function) { return static_cast<std::uint8_t>(function); }

bool is_known(ModbusFunction function) {
  switch (function) {
    case ModbusFunction::read_coils:
    case ModbusFunction::read_discrete_inputs:
    case ModbusFunction::read_holding:
    case ModbusFunction::read_input:
    case ModbusFunction::write_coil:
    case ModbusFunction::write_single:
    case ModbusFunction::loop_back:
    case ModbusFunction::write_multiple: return true;
  }
  return false;
}

/// Returns the number of data bytes in the reply to a read.
std::size_t data_size(const ModbusRequest& request) {
  return is_bit_read(request.function) ? (request.count + 7u) / 8 : 2 * std::size_t{request.count};
}

/// Returns the size of the reply's PDU if it is not an exception.
std::size_t reply_size(const ModbusRequest& request) {
  return is_read(request.function) ? 2 + data_size(request) : kShortRequest;
}

/// Returns the last field of a short request: the count or the value.
std::uint16_t count_or_value(const ModbusRequest& request) {
  switch (request.function) {
    case ModbusFunction::write_coil: return request.words.front() != 0 ? kCoilOn : std::uint16_t{0};
    case ModbusFunction::write_single:
    case ModbusFunction::loop_back: return request.words.front();
    default: return request.count;
  }
}

tl::unexpected<Fault> exception_fault(const char* exception) {
  return failure(FaultKind::refused, "modbus request", exception);
}

std::uint16_t bit_at(std::span<const std::byte> bytes, std::size_t at, std::size_t bit) {
  return (byte_at(bytes, at) >> bit & 1) != 0 ? 1 : 0;
}

Result<ModbusAnswer> decode_read_reply(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (const auto found = byte_at(reply, 1); found != data_size(request))
    return field_fault("byte count", found, data_size(request));
  if (reply.size() != reply_size(request)) return field_fault("size", reply.size(), reply_size(request));
  ModbusAnswer answer{.words = std::vector<std::uint16_t>(request.count)};
  for (std::size_t i = 0; i < answer.words.size(); ++i)
    answer.words[i] = is_bit_read(request.function) ? bit_at(reply, 2 + i / 8, i % 8) : word_at(reply, 2 + 2 * i);
  return answer;
}

Result<ModbusAnswer> decode_write_reply(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (reply.size() != reply_size(request)) return field_fault("size", reply.size(), reply_size(request));
  if (const auto found = word_at(reply, 1); found != request.address)
    return field_fault("address", found, request.address);
  const bool is_multiple = request.function == ModbusFunction::write_multiple;
  if (const auto found = word_at(reply, 3); found != count_or_value(request))
    return field_fault(is_multiple ? "count" : "value", found, count_or_value(request));
  return ModbusAnswer{};
}

/// Reads count and words of a request whose function and minimum size were checked before.
Result<void> read_contents(ModbusRequest& request, std::span<const std::byte> bytes) {
  const auto last = word_at(bytes, 3);
  request.words.clear();
  request.count = 1;
  switch (request.function) {
    case ModbusFunction::write_coil:
      if (last != kCoilOn && last != 0) return exception_fault("3");
      request.words.push_back(last == kCoilOn);
      return {};
    case ModbusFunction::write_single: request.words.push_back(last); return {};
    case ModbusFunction::loop_back:
      if (request.address != 0) return exception_fault("1");
      request.words.push_back(last);
      return {};
    case ModbusFunction::write_multiple:
      request.count = last;
      if (last < 1 || last > kMostWritten || byte_at(bytes, kShortRequest) != 2 * last ||
          bytes.size() != kWordsAt + std::size_t{2} * last)
        return exception_fault("3");
      for (std::size_t i = 0; i < last; ++i) request.words.push_back(word_at(bytes, kWordsAt + 2 * i));
      return {};
    default:
      request.count = last;
      if (last < 1 || last > (is_bit_read(request.function) ? kMostBits : kMostRead)) return exception_fault("3");
      return {};
  }
}

void append_request(const ModbusRequest& request, std::vector<std::byte>& bytes) {
  assert(is_read(request.function) || request.words.size() == request.count);
  append_byte(bytes, function_code(request.function));
  append_word(bytes, request.address);
  append_word(bytes, count_or_value(request));
  if (request.function != ModbusFunction::write_multiple) return;
  append_byte(bytes, 2 * request.words.size());
  for (const auto word : request.words) append_word(bytes, word);
}

/// Returns whether `function`, the first byte of a reply without exception flag, matches `request`.
bool is_answer_function(const ModbusRequest& request, std::uint8_t function) {
  if (function == function_code(request.function)) return true;
  const bool is_register_read = is_read(request.function) && !is_bit_read(request.function);
  return request.either_read_function && is_register_read && (function == 3 || function == 4);
}

bool is_exception_function(const ModbusRequest& request, std::uint8_t function) {
  return (function & kExceptionFlag) != 0 && is_answer_function(request, function & ~kExceptionFlag & 0xFF);
}

/// Decodes the PDU of a reply after comparing every field with its request: function, byte count and size; for a write
/// also address and count or value. Fails with corrupted, naming the field.
Result<ModbusAnswer> decode_pdu(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (reply.size() < kExceptionReplySize) return field_fault("size", reply.size(), kExceptionReplySize);
  const auto function = byte_at(reply, 0);
  if (is_exception_function(request, function)) {
    if (reply.size() != kExceptionReplySize) return field_fault("size", reply.size(), kExceptionReplySize);
    if (byte_at(reply, 1) == 0) return failure(FaultKind::corrupted, "", "exception 0, which does not exist");
    return ModbusAnswer{.exception = byte_at(reply, 1)};
  }
  if (!is_answer_function(request, function)) return field_fault("function", function, function_code(request.function));
  return is_read(request.function) ? decode_read_reply(request, reply) : decode_write_reply(request, reply);
}

/// Server: decodes function, address, count and words into `request`. Fails with refused if the answer must be an
/// exception; `what` is its code as text ("1", "2", "3").
Result<void> decode_request_pdu(ModbusRequest& request, std::span<const std::byte> bytes) {
  request.function = bytes.empty() ? ModbusFunction{} : static_cast<ModbusFunction>(byte_at(bytes, 0));
  if (!is_known(request.function)) return exception_fault("1");
  const bool is_multiple = request.function == ModbusFunction::write_multiple;
  if (bytes.size() < kShortRequest + is_multiple || (!is_multiple && bytes.size() != kShortRequest))
    return exception_fault("3");
  request.address = word_at(bytes, 1);
  if (auto read = read_contents(request, bytes); !read) return read;
  if (request.address + request.count > 0x10000) return exception_fault("2");
  return {};
}

/// Returns the size of the request at the start of `bytes`, nothing if more bytes are needed, or 0 for an unknown
/// function.
std::optional<std::size_t> request_size(std::span<const std::byte> bytes) {
  if (bytes.empty()) return std::nullopt;
  const auto function = static_cast<ModbusFunction>(byte_at(bytes, 0));
  if (!is_known(function)) return 0;
  if (function != ModbusFunction::write_multiple) return kShortRequest;
  if (bytes.size() <= kShortRequest) return std::nullopt;
  return kWordsAt + byte_at(bytes, kShortRequest);
}

/// Appends a reply. `words` are the words of a read, as many as requested.
void append_reply(const ModbusRequest& request, std::span<const std::uint16_t> words, std::vector<std::byte>& bytes) {
  append_byte(bytes, function_code(request.function));
  if (!is_read(request.function)) {
    append_word(bytes, request.address);
    append_word(bytes, count_or_value(request));
    return;
  }
  assert(words.size() == request.count);
  append_byte(bytes, data_size(request));
  if (!is_bit_read(request.function)) {
    for (const auto word : words) append_word(bytes, word);
    return;
  }
  for (std::size_t first = 0; first < words.size(); first += 8) {
    unsigned bits = 0;
    for (std::size_t i = first; i < std::min(first + 8, words.size()); ++i) bits |= (words[i] & 1u) << (i - first);
    append_byte(bytes, bits);
  }
}

void append_exception(std::byte function, std::uint8_t exception, std::vector<std::byte>& bytes) {
  bytes.push_back(function | std::byte{kExceptionFlag});
  append_byte(bytes, exception);
}

// The header consists of transaction, protocol, length and unit; the PDU follows.
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

std::vector<std::byte> finish_tcp_frame(std::vector<std::byte> frame) {
  const auto length = frame.size() - kUnitAt;
  frame[kLengthAt] = static_cast<std::byte>(length >> 8);
  frame[kLengthAt + 1] = static_cast<std::byte>(length & 0xFF);
  return frame;
}

/// Returns the fault for a wrong number in a reply. Names `key`, the setting for units that always use another number.
tl::unexpected<Fault> number_fault(const char* field, std::size_t found, std::size_t expected, const char* key) {
  return failure(FaultKind::corrupted, "",
                 fmt::format("{} of the reply is {}, expected {}, or {} = true in the link table of the rig file",
                             field, found, expected, key));
}

Result<void> check_header(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (reply.size() < kExceptionSize) return field_fault("size", reply.size(), kExceptionSize);
  if (const auto found = word_at(reply, 0); !request.any_transaction && found != request.transaction)
    return number_fault("transaction", found, request.transaction, "returns_other_transaction");
  if (const auto found = word_at(reply, 2); found != 0) return field_fault("protocol", found, 0);
  const bool has_length = is_read(request.function) || !request.miscounted_reply;
  if (const auto found = word_at(reply, kLengthAt); has_length && found != reply.size() - kUnitAt)
    return field_fault("length", found, reply.size() - kUnitAt);
  if (const auto found = byte_at(reply, kUnitAt); !request.any_unit && found != request.unit)
    return number_fault("unit", found, request.unit, "returns_other_unit");
  return {};
}

constexpr Crc kCrc{.width = 16, .polynomial = 0x8005, .initial = 0xFFFF, .reflected = true};
constexpr std::size_t kOverhead = 3;  ///< bytes: unit and CRC
constexpr std::size_t kShortestFrame = kOverhead + 1;

std::uint32_t modbus_crc(std::span<const std::byte> bytes) { return crc(kCrc, bytes); }

std::vector<std::byte> begin_frame(std::uint8_t unit) {
  std::vector<std::byte> frame;
  frame.reserve(16);
  append_byte(frame, unit);
  return frame;
}

std::vector<std::byte> finish_rtu_frame(std::vector<std::byte> frame) {
  append_rtu_crc(frame);
  return frame;
}

/// Returns whether the last two bytes of `frame` are its CRC.
bool has_valid_crc(std::span<const std::byte> frame) {
  const auto last = frame.size() - 2;
  return modbus_crc(frame.first(last)) == (byte_at(frame, last) | unsigned{byte_at(frame, last + 1)} << 8);
}

std::span<const std::byte> pdu(std::span<const std::byte> frame) { return frame.subspan(1, frame.size() - kOverhead); }

}  // namespace

std::string exception_meaning(std::uint8_t exception) {
  switch (exception) {
    case 1: return "illegal function";
    case 2: return "illegal data address";
    case 3: return "illegal data value";
    case 4: return "server device failure";
    case 5: return "acknowledge, request in progress";
    case 6: return "server device busy";
    case 8: return "memory parity error";
    case 10: return "gateway path unavailable";
    case 11: return "gateway target did not respond";
    default: return "vendor-specific";
  }
}

std::vector<std::byte> encode_request(const ModbusRequest& request) {
  auto frame = begin_frame(request.transaction, request.unit);
  append_request(request, frame);
  return finish_tcp_frame(std::move(frame));
}

Result<ModbusAnswer> decode_answer(const ModbusRequest& request, std::span<const std::byte> reply) {
  if (auto header = check_header(request, reply); !header) return failure(std::move(header.error()));
  return decode_pdu(request, reply.subspan(kFunctionAt));
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
  if (*length != frame.size()) return failure(FaultKind::corrupted, "modbus request", "not exactly one frame");

  ModbusRequest request{.transaction = word_at(frame, 0), .unit = byte_at(frame, kUnitAt)};
  if (auto decoded = decode_request_pdu(request, frame.subspan(kFunctionAt)); !decoded)
    return failure(std::move(decoded.error()));
  return request;
}

std::vector<std::byte> encode_reply(const ModbusRequest& request, std::span<const std::uint16_t> words) {
  auto frame = begin_frame(request.transaction, request.unit);
  append_reply(request, words, frame);
  return finish_tcp_frame(std::move(frame));
}

std::vector<std::byte> encode_exception(std::span<const std::byte> request_frame, std::uint8_t code) {
  assert(request_frame.size() > kFunctionAt);
  auto frame = begin_frame(word_at(request_frame, 0), byte_at(request_frame, kUnitAt));
  append_exception(request_frame[kFunctionAt], code, frame);
  return finish_tcp_frame(std::move(frame));
}

void append_rtu_crc(std::vector<std::byte>& frame) {
  const auto value = modbus_crc(frame);
  append_byte(frame, value & 0xFF);
  append_byte(frame, value >> 8);
}

std::vector<std::byte> encode_rtu_request(const ModbusRequest& request) {
  auto frame = begin_frame(request.unit);
  append_request(request, frame);
  return finish_rtu_frame(std::move(frame));
}

Result<std::optional<std::size_t>> rtu_answer_size(const ModbusRequest& request, std::span<const std::byte> bytes) {
  if (!bytes.empty() && byte_at(bytes, 0) != request.unit) return field_fault("unit", byte_at(bytes, 0), request.unit);
  if (bytes.size() < 2) return std::nullopt;
  const auto function = byte_at(bytes, 1);
  if (is_exception_function(request, function)) return kOverhead + kExceptionReplySize;
  if (!is_answer_function(request, function))
    return field_fault("function", function, static_cast<std::uint8_t>(request.function));
  const auto size = kOverhead + reply_size(request);
  if (is_read(request.function) && bytes.size() > 2 && byte_at(bytes, 2) + kOverhead + 2u != size)
    return field_fault("byte count", byte_at(bytes, 2), size - kOverhead - 2);
  return size;
}

Result<ModbusAnswer> decode_rtu_answer(const ModbusRequest& request, std::span<const std::byte> frame) {
  const auto size = rtu_answer_size(request, frame);
  if (!size) return failure(size.error());
  const auto expected = size->value_or(kOverhead + kExceptionReplySize);
  if (frame.size() != expected) return field_fault("size", frame.size(), expected);
  if (!has_valid_crc(frame)) return failure(FaultKind::corrupted, "", "the reply has a wrong CRC");
  return decode_pdu(request, pdu(frame));
}

RtuFinding find_rtu_answer(const ModbusRequest& request, std::span<const std::byte> bytes) {
  constexpr std::size_t kHeader = 3;  // unit, function, byte count
  RtuFinding found;
  // found.fault is the fault of a complete frame.
  bool is_whole = false;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    const auto rest = bytes.subspan(at);
    const auto size = rtu_answer_size(request, rest);
    if (size && (!*size || rest.size() < **size)) {
      found.has_partial_frame = found.has_partial_frame || rest.size() >= kHeader;
      continue;
    }
    auto answer = size ? decode_rtu_answer(request, rest.first(**size)) : Result<ModbusAnswer>(failure(size.error()));
    if (answer) {
      found.answer = std::move(*answer);
      found.begin = at;
      found.end = at + **size;
      return found;
    }
    if (found.fault.what.empty() || (size.has_value() && !is_whole)) found.fault = std::move(answer.error());
    is_whole = is_whole || size.has_value();
  }
  return found;
}

Result<std::optional<std::size_t>> rtu_request_size(std::span<const std::byte> bytes) {
  const auto size = bytes.empty() ? std::nullopt : request_size(bytes.subspan(1));
  if (!size) return std::nullopt;
  if (*size == 0) return failure(FaultKind::corrupted, "modbus request", "unknown function");
  return bytes.size() < kOverhead + *size ? std::nullopt : std::optional(kOverhead + *size);
}

Result<ModbusRequest> decode_rtu_request(std::span<const std::byte> frame) {
  if (frame.size() < kShortestFrame || frame.size() > kLongestRtuFrame)
    return failure(FaultKind::corrupted, "modbus request", "not exactly one frame");
  if (!has_valid_crc(frame)) return failure(FaultKind::corrupted, "modbus request", "wrong CRC");
  ModbusRequest request{.unit = byte_at(frame, 0)};
  if (auto decoded = decode_request_pdu(request, pdu(frame)); !decoded) return failure(std::move(decoded.error()));
  return request;
}

std::vector<std::byte> encode_rtu_reply(const ModbusRequest& request, std::span<const std::uint16_t> words) {
  auto frame = begin_frame(request.unit);
  append_reply(request, words, frame);
  return finish_rtu_frame(std::move(frame));
}

std::vector<std::byte> encode_rtu_exception(std::span<const std::byte> request_frame, std::uint8_t code) {
  assert(request_frame.size() >= 2);
  auto frame = begin_frame(byte_at(request_frame, 0));
  append_exception(request_frame[1], code, frame);
  return finish_rtu_frame(std::move(frame));
}

}  // namespace gyrotherm::drivers
