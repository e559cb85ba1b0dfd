// SPDX-License-Identifier: Apache-2.0
/// Modbus messages: requests and answers (the PDU), and their frames on TCP and serial lines. Pure functions, shared by
/// the client and the virtual chamber's server. Modbus Application Protocol V1.1b3; Messaging on TCP/IP Implementation
/// Guide V1.0b, section 3.1.3; MODBUS over Serial Line V1.02, section 2.5.1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "drivers/checksum.hpp"

namespace gyrotherm::drivers {

inline constexpr std::uint16_t kMostBits = 2000;  ///< maximum per request

enum class ModbusFunction : std::uint8_t {
  read_coils = 1,
  read_discrete_inputs = 2,
  read_holding = 3,
  read_input = 4,
  write_coil = 5,
  write_single = 6,
  loop_back = 8,
  write_multiple = 16,
};

struct ModbusRequest {
  /// Modbus TCP only.
  std::uint16_t transaction{};
  std::uint8_t unit{};
  ModbusFunction function{};
  std::uint16_t address{};
  std::uint16_t count{};  ///< registers or bits
  /// Words to write; exactly one for a coil or a loop-back.
  std::vector<std::uint16_t> words{};
  /// Accepts an answer by function 4 to a read by function 3, and the reverse. Not sent.
  bool either_read_function{};
  // Accept any length in the reply to a write, any transaction number, any unit number. Not sent.
  bool miscounted_reply{};
  bool any_transaction{};
  bool any_unit{};
};

/// Answer of a unit: words, or an exception. A bit is a word that is 0 or 1; a write has no words.
struct ModbusAnswer {
  std::uint8_t exception{};  ///< 0 for none
  std::vector<std::uint16_t> words{};
};

/// Returns the standard's name of an exception: "illegal data address".
[[nodiscard]] std::string exception_meaning(std::uint8_t exception);

[[nodiscard]] constexpr bool reads(ModbusFunction function) { return static_cast<std::uint8_t>(function) <= 4; }
[[nodiscard]] constexpr bool reads_bits(ModbusFunction function) { return static_cast<std::uint8_t>(function) <= 2; }

[[nodiscard]] inline std::uint16_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(byte_at(bytes, at) << 8 | byte_at(bytes, at + 1));
}

[[nodiscard]] std::vector<std::byte> encode_request(const ModbusRequest& request);

/// Decodes a reply. First compares its fields with the request, except those that the request exempts: transaction,
/// protocol 0, length, unit, function and byte count; for a write also address and count or value. Fails with
/// corrupted, naming the field.
[[nodiscard]] Result<ModbusAnswer> decode_answer(const ModbusRequest& request, std::span<const std::byte> reply);

/// Server: returns the length of the first whole frame in `bytes`, or nothing if more bytes are needed. Fails with
/// corrupted if the bytes cannot become a frame.
[[nodiscard]] Result<std::optional<std::size_t>> frame_length(std::span<const std::byte> bytes);
/// Server: decodes one whole frame. Fails with refused if the answer must be an exception; `what` is its code as text
/// ("1", "3").
[[nodiscard]] Result<ModbusRequest> decode_request(std::span<const std::byte> frame);
[[nodiscard]] std::vector<std::byte> encode_reply(const ModbusRequest& request, std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::byte> encode_exception(std::span<const std::byte> request_frame, std::uint8_t code);

inline constexpr std::size_t kLongestRtuFrame = 256;

[[nodiscard]] std::vector<std::byte> encode_rtu_request(const ModbusRequest& request);

/// Returns the size of the answer at the start of `bytes`, or nothing if more bytes are needed. Fails with corrupted as
/// soon as unit, function or byte count cannot belong to an answer to `request`.
[[nodiscard]] Result<std::optional<std::size_t>> rtu_answer_size(const ModbusRequest& request,
                                                                 std::span<const std::byte> bytes);
/// Decodes an answer after comparing every field with its request: unit, function, byte count and size, for writes
/// address and count or value, and the CRC. Fails with corrupted, naming the field. The reply to a read contains
/// neither the address of its words nor a transaction number, so these cannot be checked.
[[nodiscard]] Result<ModbusAnswer> decode_rtu_answer(const ModbusRequest& request, std::span<const std::byte> frame);

inline constexpr std::size_t kShortestRtuAnswer = 5;  ///< an exception

/// Result of searching the received bytes for the answer to a request.
struct RtuFinding {
  /// The answer in the first matching frame, and the position of that frame.
  std::optional<ModbusAnswer> answer{};
  std::size_t begin = 0, end = 0;
  /// The bytes end within a frame that matches in its first three bytes.
  bool has_partial_frame = false;
  /// Reason for rejecting the most likely frame, if there is no answer.
  Fault fault{FaultKind::corrupted, "", ""};
};
/// Returns the first frame that decode_rtu_answer() accepts, at any position. Noise of an idle bus and frames of other
/// units may precede it; bytes after it are ignored.
[[nodiscard]] RtuFinding find_rtu_answer(const ModbusRequest& request, std::span<const std::byte> bytes);

/// Server: returns the size of the first frame in `bytes`, or nothing if more bytes are needed. Fails with corrupted if
/// the function is unknown; such a frame ends at the next silence.
[[nodiscard]] Result<std::optional<std::size_t>> rtu_request_size(std::span<const std::byte> bytes);
/// Server: decodes one whole frame. Fails with corrupted if the CRC is wrong; the server must not answer then. Fails
/// with refused if the answer must be an exception; `what` is its code as text ("1", "3").
[[nodiscard]] Result<ModbusRequest> decode_rtu_request(std::span<const std::byte> frame);
[[nodiscard]] std::vector<std::byte> encode_rtu_reply(const ModbusRequest& request,
                                                      std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::byte> encode_rtu_exception(std::span<const std::byte> request_frame, std::uint8_t code);

/// Appends the CRC of the bytes in `frame`.
void append_rtu_crc(std::vector<std::byte>& frame);

}  // namespace gyrotherm::drivers
