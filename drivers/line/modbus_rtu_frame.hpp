/// Modbus RTU frames as bytes: unit, protocol data unit, CRC-16 with its low byte first. Pure, both ends. Modbus over
/// Serial Line V1.02, section 2.5.1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "drivers/line/modbus_pdu.hpp"

namespace gyrotherm {

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

}  // namespace gyrotherm
