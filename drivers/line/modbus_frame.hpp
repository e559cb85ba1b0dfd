// SPDX-License-Identifier: Apache-2.0
/// Modbus as bytes: requests and answers (the PDU), and the frames that carry them on TCP and on a serial line. Pure
/// functions, shared by the client's guarded exchange and the virtual chamber's server. Modbus Application Protocol
/// V1.1b3; Messaging on TCP/IP Implementation Guide V1.0b, section 3.1.3; MODBUS over Serial Line V1.02, section 2.5.1.
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

inline constexpr std::uint16_t kMostBits = 2000;  ///< that one request may read

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
  std::uint16_t transaction{};  ///< Modbus TCP alone
  std::uint8_t unit{};
  ModbusFunction function{};
  std::uint16_t address{};
  std::uint16_t count{};               ///< registers or bits read or written
  std::vector<std::uint16_t> words{};  ///< written; one of a coil or a loop-back
  bool either_read_function{};         ///< not on the wire: a read by 3 may be answered by 4, and the other way round
  // Not on the wire:
  bool miscounted_reply{};  ///< any length in a write's reply
  bool any_transaction{};   ///< any transaction number in the reply
  bool any_unit{};          ///< any unit number in the reply
};

/// What a unit answers: words (a bit is a word that is 0 or 1; none for a write), or an exception.
struct ModbusAnswer {
  std::uint8_t exception{};  ///< 0: none
  std::vector<std::uint16_t> words{};
};

/// "illegal data address"
[[nodiscard]] std::string exception_meaning(std::uint8_t exception);

[[nodiscard]] constexpr bool reads(ModbusFunction function) { return static_cast<std::uint8_t>(function) <= 4; }
[[nodiscard]] constexpr bool reads_bits(ModbusFunction function) { return static_cast<std::uint8_t>(function) <= 2; }

[[nodiscard]] inline std::uint16_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(byte_at(bytes, at) << 8 | byte_at(bytes, at + 1));
}

[[nodiscard]] std::vector<std::byte> encode_request(const ModbusRequest& request);

/// Compares every field of a reply with its request (transaction, protocol 0, length, unit, function, byte count; for
/// writes address and count or value) except those that the request exempts. Fails with corrupted, naming the field.
[[nodiscard]] Result<ModbusAnswer> decode_answer(const ModbusRequest& request, std::span<const std::byte> reply);

/// The server's side: the length of the first whole frame in `bytes`; nothing if more bytes are needed; a fault
/// (corrupted) if this cannot become a frame.
[[nodiscard]] Result<std::optional<std::size_t>> frame_length(std::span<const std::byte> bytes);
/// Decodes one whole frame. Fails with refused and `what` = the exception code as text ("1", "3") where the server must
/// answer with an exception.
[[nodiscard]] Result<ModbusRequest> decode_request(std::span<const std::byte> frame);
[[nodiscard]] std::vector<std::byte> encode_reply(const ModbusRequest& request, std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::byte> encode_exception(std::span<const std::byte> request_frame, std::uint8_t code);

inline constexpr std::size_t kLongestRtuFrame = 256;

[[nodiscard]] std::vector<std::byte> encode_rtu_request(const ModbusRequest& request);

/// The size of the answer that begins with `bytes`; nothing if more bytes are needed. Fails with corrupted as soon as
/// unit, function or byte count show that this does not answer `request`.
[[nodiscard]] Result<std::optional<std::size_t>> rtu_answer_size(const ModbusRequest& request,
                                                                 std::span<const std::byte> bytes);
/// Compares every field of an answer with its request: unit, function, byte count and size, for writes address and
/// count or value, and the CRC. Fails with corrupted, naming the field. What the frame does not hold it cannot tell:
/// which address a read's words come from, and when.
[[nodiscard]] Result<ModbusAnswer> decode_rtu_answer(const ModbusRequest& request, std::span<const std::byte> frame);

inline constexpr std::size_t kShortestRtuAnswer = 5;  ///< an exception

/// A search for the answer to a request among the bytes of a line.
struct RtuFinding {
  std::optional<ModbusAnswer> answer{};  ///< content of the first fitting frame
  std::size_t begin = 0, end = 0;        ///< position of that frame
  /// The bytes end within a frame whose first three bytes fit.
  bool begun = false;
  /// Without an answer: the reason why the likeliest frame does not fit.
  Fault fault{FaultKind::corrupted, "", ""};
};
/// Returns the first frame that decode_rtu_answer() accepts, wherever it begins. Noise of an idle bus and the frames of
/// other units precede it; bytes that follow it count nothing.
[[nodiscard]] RtuFinding find_rtu_answer(const ModbusRequest& request, std::span<const std::byte> bytes);

/// The server's side: the size of the first frame in `bytes`; nothing if more bytes are needed. Fails with corrupted if
/// its function is unknown: then the frame ends where the line falls silent.
[[nodiscard]] Result<std::optional<std::size_t>> rtu_request_size(std::span<const std::byte> bytes);
/// Decodes one whole frame. Fails with corrupted (CRC: to be met with silence), or with refused and `what` = the
/// exception code as text ("1", "3") where the server must answer with an exception.
[[nodiscard]] Result<ModbusRequest> decode_rtu_request(std::span<const std::byte> frame);
[[nodiscard]] std::vector<std::byte> encode_rtu_reply(const ModbusRequest& request,
                                                      std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::byte> encode_rtu_exception(std::span<const std::byte> request_frame, std::uint8_t code);

/// Appends the CRC of all that is there.
void append_rtu_crc(std::vector<std::byte>& frame);

}  // namespace gyrotherm::drivers
