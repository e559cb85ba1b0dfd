#include "simulator/modbus_server.hpp"

#include <charconv>

#include "drivers/line/modbus_frame.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kUnitAt = 6;  ///< byte of the unit in a Modbus TCP frame

std::uint8_t exception_code(const Fault& refusal) {
  auto code = static_cast<std::uint8_t>(ModbusException::illegal_value);
  std::from_chars(refusal.what.data(), refusal.what.data() + refusal.what.size(), code);
  return code;
}

}  // namespace

bool ModbusSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  std::span<const std::byte> rest(pending_);
  while (true) {
    const auto length = frame_length(rest);
    if (!length) return false;
    if (!*length) break;
    const auto frame = rest.first(**length);
    if (std::to_integer<std::uint8_t>(frame[kUnitAt]) == registers_.unit()) {
      const auto answered = answer(frame);
      reply.insert(reply.end(), answered.begin(), answered.end());
    }
    rest = rest.subspan(**length);
  }
  pending_.erase(pending_.begin(), pending_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return true;
}

std::vector<std::byte> ModbusSession::answer(std::span<const std::byte> frame) {
  const auto request = decode_request(frame);
  if (!request) return encode_exception(frame, exception_code(request.error()));
  words_.clear();
  const auto done = request->words.empty() ? registers_.read(request->address, request->count, words_)
                                           : registers_.write(request->address, request->words);
  if (!done) return encode_exception(frame, static_cast<std::uint8_t>(done.error()));
  return encode_reply(*request, words_);
}

}  // namespace gyrotherm
