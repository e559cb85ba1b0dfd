// SPDX-License-Identifier: Apache-2.0
/// Any bytes as a request and as a reply; what decodes must encode to the same bytes. Half of the inputs get a CRC that
/// fits, or hardly any would pass it.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "drivers/line/modbus_frame.hpp"

namespace gyrotherm::drivers {

namespace {

void check_reply(const ModbusRequest& asked, std::span<const std::byte> bytes) {
  const auto size = rtu_answer_size(asked, bytes);
  const auto answer = decode_rtu_answer(asked, bytes);
  if (!answer) return;
  if (!size || !*size || **size != bytes.size()) std::abort();
  if (answer->exception != 0) return;
  if (answer->words.size() != (reads(asked.function) ? asked.count : 0u)) std::abort();
  if (!reads_bits(asked.function) && !std::ranges::equal(encode_rtu_reply(asked, answer->words), bytes)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto raw = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(raw.begin(), raw.end());
  if (size > 0 && data[size - 1] % 2 == 0) append_rtu_crc(bytes);

  const auto unit = bytes.empty() ? std::uint8_t{1} : byte_at(bytes, 0);
  for (const auto function : {ModbusFunction::read_coils, ModbusFunction::read_holding, ModbusFunction::read_input})
    check_reply({.unit = unit, .function = function, .address = 7, .count = static_cast<std::uint16_t>(1 + size % 100)},
                bytes);
  check_reply({.unit = unit, .function = ModbusFunction::write_single, .address = 7, .count = 1, .words = {1}}, bytes);

  const auto length = rtu_request_size(bytes);
  if (!length || !*length) return 0;
  const auto frame = std::span<const std::byte>(bytes).first(**length);
  if (const auto request = decode_rtu_request(frame);
      request && !std::ranges::equal(encode_rtu_request(*request), frame))
    std::abort();
  return 0;
}

}  // namespace gyrotherm::drivers
