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
  /// Words to write: none for a read, exactly one for write_coil, write_single and loop_back.
  std::vector<std::uint16_t> words{};

  // Deviations to accept in the reply, not part of the request frame.
  /// Function 4 may answer a read by function 3, and the reverse.
  bool either_read_function{};
  // The length in the reply to a write, the transaction number or the unit number may have any value.
  bool miscounted_reply{};
  bool any_transaction{};
  bool any_unit{};
};

/// Answer of a unit: words, or an exception. A bit is a word that is 0 or 1; a write has no words.
struct ModbusAnswer {
  std::uint8_t exception{};  ///< code; 0 if there is none
  std::vector<std::uint16_t> words{};
};

/// Returns the name of an exception in the standard, such as "illegal data address".
[[nodiscard]] std::string exception_meaning(std::uint8_t exception);

[[nodiscard]] constexpr bool is_read(ModbusFunction function) { return static_cast<std::uint8_t>(function) <= 4; }
[[nodiscard]] constexpr bool is_bit_read(ModbusFunction function) { return static_cast<std::uint8_t>(function) <= 2; }

[[nodiscard]] inline std::uint16_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(byte_at(bytes, at) << 8 | byte_at(bytes, at + 1));
}

[[nodiscard]] std::vector<std::byte> encode_request(const ModbusRequest& request);

/// Decodes a reply after comparing it with the request: transaction, protocol (0), length, unit, function and byte
/// count; for a write also address and count or value. Skips the fields that may deviate according to the request.
/// Fails with corrupted, naming the field.
[[nodiscard]] Result<ModbusAnswer> decode_answer(const ModbusRequest& request, std::span<const std::byte> reply);

/// Server: returns the length of the first complete frame in `bytes`, or nothing if more bytes are needed. Fails with
/// corrupted if the bytes cannot become a frame.
[[nodiscard]] Result<std::optional<std::size_t>> frame_length(std::span<const std::byte> bytes);
/// Server: decodes one complete frame. Fails with corrupted if it is not exactly one frame, and with refused if the
/// answer must be an exception; `what` is the exception code as text ("1", "3").
[[nodiscard]] Result<ModbusRequest> decode_request(std::span<const std::byte> frame);
[[nodiscard]] std::vector<std::byte> encode_reply(const ModbusRequest& request, std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::byte> encode_exception(std::span<const std::byte> request_frame, std::uint8_t code);

inline constexpr std::size_t kLongestRtuFrame = 256;

[[nodiscard]] std::vector<std::byte> encode_rtu_request(const ModbusRequest& request);

/// Returns the size of the answer at the start of `bytes`, or nothing if more bytes are needed. Fails with corrupted if
/// the unit, function or byte count received so far cannot belong to an answer to `request`.
[[nodiscard]] Result<std::optional<std::size_t>> rtu_answer_size(const ModbusRequest& request,
                                                                 std::span<const std::byte> bytes);
/// Decodes an answer after comparing it with its request: unit, function, byte count, size and CRC; for a write also
/// address and count or value. Fails with corrupted, naming the field. The reply to a read contains no address and no
/// transaction number, so these cannot be checked.
[[nodiscard]] Result<ModbusAnswer> decode_rtu_answer(const ModbusRequest& request, std::span<const std::byte> frame);

inline constexpr std::size_t kShortestRtuAnswer = 5;  ///< bytes; an exception

/// Result of searching the received bytes for the answer to a request.
struct RtuFinding {
  /// The answer, if a frame matches. The frame extends from `begin` to `end`.
  std::optional<ModbusAnswer> answer{};
  std::size_t begin = 0, end = 0;
  /// The bytes end with an incomplete frame of at least three bytes that may be the answer.
  bool has_partial_frame = false;
  /// If there is no answer, the reason for rejecting the most likely frame.
  Fault fault{FaultKind::corrupted, "", ""};
};
/// Searches for the first frame that decode_rtu_answer() accepts. Noise of an idle bus and frames of other units may
/// precede it; bytes after it are ignored.
[[nodiscard]] RtuFinding find_rtu_answer(const ModbusRequest& request, std::span<const std::byte> bytes);

/// Server: returns the size of the first frame in `bytes`, or nothing if more bytes are needed. Fails with corrupted if
/// the function is unknown; the caller must then wait for silence, which ends the frame.
[[nodiscard]] Result<std::optional<std::size_t>> rtu_request_size(std::span<const std::byte> bytes);
/// Server: decodes one complete frame. Fails with corrupted if the CRC is wrong; the server must then not answer. Fails
/// with refused if the answer must be an exception; `what` is the exception code as text ("1", "3").
[[nodiscard]] Result<ModbusRequest> decode_rtu_request(std::span<const std::byte> frame);
[[nodiscard]] std::vector<std::byte> encode_rtu_reply(const ModbusRequest& request,
                                                      std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::byte> encode_rtu_exception(std::span<const std::byte> request_frame, std::uint8_t code);

/// Appends the CRC of the bytes in `frame`.
void append_rtu_crc(std::vector<std::byte>& frame);

}  // namespace gyrotherm::drivers
