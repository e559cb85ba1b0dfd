// SPDX-License-Identifier: Apache-2.0
/// Fuzzes Modbus RTU frames with any bytes as a request, as a reply, and as noise around a reply. Decoded frames must
/// encode to the same bytes. Half of the inputs get a correct CRC, because few would have one by chance.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "drivers/line/modbus_frame.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

namespace {

/// Requires that the frame found is a valid answer, and the first one in the bytes.
void check_search(const ModbusRequest& asked, std::span<const std::byte> bytes) {
  const auto found = find_rtu_answer(asked, bytes);
  if (!found.answer) {
    if (!bytes.empty() && decode_rtu_answer(asked, bytes)) std::abort();
    return;
  }
  if (found.begin >= found.end || found.end > bytes.size() || found.end - found.begin < kShortestRtuAnswer)
    std::abort();
  if (!decode_rtu_answer(asked, bytes.subspan(found.begin, found.end - found.begin))) std::abort();
  if (find_rtu_answer(asked, bytes.first(found.end - 1)).answer) std::abort();
}

/// Requires that an answer is found between noise, unless the noise itself contains an answer.
void check_noise(const ModbusRequest& asked, std::span<const std::byte> noise) {
  auto bytes = std::vector(noise.begin(), noise.end());
  const auto reply = encode_rtu_reply(asked, std::vector<std::uint16_t>(asked.count, 0x5A3C));
  bytes.insert(bytes.end(), reply.begin(), reply.end());
  bytes.insert(bytes.end(), noise.begin(), noise.end());
  const auto found = find_rtu_answer(asked, bytes);
  if (!found.answer || found.begin > noise.size()) std::abort();
}

void check_reply(const ModbusRequest& asked, std::span<const std::byte> bytes) {
  check_search(asked, bytes);
  const auto size = rtu_answer_size(asked, bytes);
  const auto answer = decode_rtu_answer(asked, bytes);
  if (!answer) return;
  if (!size || !*size || **size != bytes.size()) std::abort();
  if (answer->exception != 0) return;
  if (answer->words.size() != (is_read(asked.function) ? asked.count : 0u)) std::abort();
  if (!is_bit_read(asked.function) && !std::ranges::equal(encode_rtu_reply(asked, answer->words), bytes)) std::abort();
}

}  // namespace

FUZZ_TARGET(modbus_rtu_frame, const std::uint8_t* data, std::size_t size) {
  const auto raw = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(raw.begin(), raw.end());
  if (size > 0 && data[size - 1] % 2 == 0) append_rtu_crc(bytes);

  const auto unit = bytes.empty() ? std::uint8_t{1} : byte_at(bytes, 0);
  for (const auto function : {ModbusFunction::read_coils, ModbusFunction::read_holding, ModbusFunction::read_input})
    check_reply({.unit = unit, .function = function, .address = 7, .count = static_cast<std::uint16_t>(1 + size % 100)},
                bytes);
  check_reply({.unit = unit, .function = ModbusFunction::write_single, .address = 7, .count = 1, .words = {1}}, bytes);

  check_noise({.unit = unit, .function = ModbusFunction::read_holding, .address = 7, .count = 2}, bytes);

  const auto length = rtu_request_size(bytes);
  if (!length || !*length) return 0;
  const auto frame = std::span<const std::byte>(bytes).first(**length);
  if (const auto request = decode_rtu_request(frame);
      request && !std::ranges::equal(encode_rtu_request(*request), frame))
    std::abort();
  return 0;
}

}  // namespace gyrotherm::drivers
