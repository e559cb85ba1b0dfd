#include "simulator/servers/modbus_server.hpp"

#include <charconv>

#include "drivers/line/modbus_frame.hpp"
#include "drivers/line/modbus_rtu_frame.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kUnitAt = 6;  ///< byte of the unit in a Modbus TCP frame
constexpr std::size_t kLongestPending = 512;

std::uint8_t exception_code(const Fault& refusal) {
  auto code = static_cast<std::uint8_t>(ModbusException::illegal_value);
  std::from_chars(refusal.what.data(), refusal.what.data() + refusal.what.size(), code);
  return code;
}

std::uint8_t code(ModbusException exception) { return static_cast<std::uint8_t>(exception); }

bool is_silent(const ChamberRegisters& registers) { return registers.map().simulated.silent_exceptions; }

void append(std::vector<std::byte>& to, const std::vector<std::byte>& bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

}  // namespace

tl::expected<void, ModbusException> carry_out(ChamberRegisters& registers, const ModbusRequest& request,
                                              std::vector<std::uint16_t>& words) {
  switch (request.function) {
    case ModbusFunction::read_coils:
    case ModbusFunction::read_discrete_inputs:
    case ModbusFunction::read_holding:
    case ModbusFunction::read_input:
      return registers.read(static_cast<ReadFunction>(request.function), request.address, request.count, words);
    case ModbusFunction::write_coil: return registers.write(WriteFunction::coil, request.address, request.words);
    case ModbusFunction::write_single:
      return registers.write(WriteFunction::one_register, request.address, request.words);
    case ModbusFunction::write_multiple:
      return registers.write(WriteFunction::registers, request.address, request.words);
    case ModbusFunction::loop_back: return {};
  }
  return tl::unexpected(ModbusException::illegal_function);
}

bool ModbusSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  std::span<const std::byte> rest(pending_);
  while (true) {
    const auto length = frame_length(rest);
    if (!length) return false;
    if (!*length) break;
    const auto frame = rest.first(**length);
    if (std::to_integer<std::uint8_t>(frame[kUnitAt]) == registers_.unit()) append(reply, answer(frame));
    rest = rest.subspan(**length);
  }
  pending_.erase(pending_.begin(), pending_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return true;
}

std::vector<std::byte> ModbusSession::answer(std::span<const std::byte> frame) {
  const auto request = decode_request(frame);
  const auto refuse = [&](std::uint8_t exception) {
    return is_silent(registers_) ? std::vector<std::byte>() : encode_exception(frame, exception);
  };
  if (!request) return refuse(exception_code(request.error()));
  if (request->function == ModbusFunction::loop_back) return refuse(code(ModbusException::illegal_function));
  words_.clear();
  if (const auto done = carry_out(registers_, *request, words_); !done) return refuse(code(done.error()));
  return encode_reply(*request, words_);
}

bool ModbusRtuSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  std::span<const std::byte> rest(pending_);
  while (!rest.empty()) {
    const auto size = rtu_request_size(rest);
    if (!size) rest = {};
    if (!size || !*size || **size > rest.size()) break;
    answer(rest.first(**size), reply);
    rest = rest.subspan(**size);
  }
  if (rest.size() > kLongestPending) rest = {};
  pending_.erase(pending_.begin(), pending_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return true;
}

void ModbusRtuSession::answer(std::span<const std::byte> frame, std::vector<std::byte>& reply) {
  if (std::to_integer<std::uint8_t>(frame.front()) != registers_.unit()) return;
  const auto request = decode_rtu_request(frame);
  if (!request && request.error().kind == FaultKind::corrupted) return;
  const auto refuse = [&](std::uint8_t exception) {
    if (!is_silent(registers_)) append(reply, encode_rtu_exception(frame, exception));
  };
  if (!request) return refuse(exception_code(request.error()));
  words_.clear();
  if (const auto done = carry_out(registers_, *request, words_); !done) return refuse(code(done.error()));
  append(reply, encode_rtu_reply(*request, words_));
}

std::unique_ptr<Session> make_modbus_session(ChamberRegisters& registers) {
  if (registers.map().link.kind == LinkKind::tcp) return std::make_unique<ModbusSession>(registers);
  return std::make_unique<ModbusRtuSession>(registers);
}

}  // namespace gyrotherm
