// SPDX-License-Identifier: Apache-2.0
/// Fuzzes Modbus TCP frames with any bytes as a reply and as a request. Decoded frames must encode to the same bytes.
#include <algorithm>
#include <cstdlib>

#include "drivers/line/modbus_frame.hpp"
#include "tests/support/fuzz_target.hpp"
#include "tests/support/modbus_words.hpp"

namespace gyrotherm::drivers {

FUZZ_TARGET(modbus_frame, const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));

  ModbusRequest request{.unit = 1, .function = ModbusFunction::read_holding, .address = 7, .count = 2};
  if (size > 2) request.transaction = static_cast<std::uint16_t>(data[0] << 8 | data[1]);
  if (const auto words = decode_reply(request, bytes); words && words->size() != request.count) std::abort();
  request.function = ModbusFunction::write_multiple;
  request.words = {1, 2};
  if (const auto words = decode_reply(request, bytes); words && !words->empty()) std::abort();

  const auto length = frame_length(bytes);
  if (!length || !*length) return 0;
  const auto frame = bytes.first(**length);
  const auto decoded = decode_request(frame);
  if (decoded && !std::ranges::equal(encode_request(*decoded), frame)) std::abort();
  return 0;
}

}  // namespace gyrotherm::drivers
