/// Modbus TCP frames as bytes: pure functions, shared by the client's guarded exchange and the virtual chamber's
/// server. Modbus Messaging on TCP/IP Implementation Guide V1.0b, section 3.1.3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "drivers/line/modbus_pdu.hpp"

namespace gyrotherm {

[[nodiscard]] std::vector<std::byte> encode_request(const ModbusRequest& request);

/// Compares every field of a reply with its request (transaction, protocol 0, length, unit, function, byte count; for
/// writes address and count or value). Fails with corrupted, naming the field.
[[nodiscard]] Result<ModbusAnswer> decode_answer(const ModbusRequest& request, std::span<const std::byte> reply);
/// The registers read (none for a write); an exception, named, is a fault too (refused).
[[nodiscard]] Result<std::vector<std::uint16_t>> decode_reply(const ModbusRequest& request,
                                                              std::span<const std::byte> reply);

/// The server's side: the length of the first whole frame in `bytes`; nothing if more bytes are needed; a fault
/// (corrupted) if this cannot become a frame.
[[nodiscard]] Result<std::optional<std::size_t>> frame_length(std::span<const std::byte> bytes);
/// Decodes one whole frame. Fails with refused and `what` = the exception code as text ("1", "3") where the server must
/// answer with an exception.
[[nodiscard]] Result<ModbusRequest> decode_request(std::span<const std::byte> frame);
[[nodiscard]] std::vector<std::byte> encode_reply(const ModbusRequest& request, std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::byte> encode_exception(std::span<const std::byte> request_frame, std::uint8_t code);

}  // namespace gyrotherm
