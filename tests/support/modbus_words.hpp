// SPDX-License-Identifier: Apache-2.0
/// Reads the registers from the answer to a Modbus request.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "drivers/line/modbus_frame.hpp"

namespace gyrotherm::drivers {

/// Returns the registers of an answer. Returns an exception as a fault (refused), such as "exception 2, illegal data
/// address".
[[nodiscard]] inline Result<std::vector<std::uint16_t>> words_of(ModbusAnswer answer) {
  if (answer.exception == 0) return std::move(answer.words);
  return failure(FaultKind::refused, "",
                 fmt::format("exception {}, {}", answer.exception, exception_meaning(answer.exception)));
}

/// Decodes a reply. Returns the registers that it contains (none for a write), or an exception as a fault (refused).
[[nodiscard]] inline Result<std::vector<std::uint16_t>> decode_reply(const ModbusRequest& request,
                                                                     std::span<const std::byte> reply) {
  return decode_answer(request, reply).and_then(words_of);
}

}  // namespace gyrotherm::drivers
