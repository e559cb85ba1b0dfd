// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/modbus_server.hpp"

#include <charconv>
#include <optional>

#include "drivers/line/modbus_frame.hpp"

namespace gyrotherm::simulator {
namespace {

/// Index of the unit byte in a Modbus TCP frame.
constexpr std::size_t kUnitOffset = 6;
constexpr std::size_t kLongestPending = 512;

std::uint8_t exception_code(const Fault& refusal) {
  auto code = static_cast<std::uint8_t>(ModbusException::illegal_value);
  std::from_chars(refusal.what.data(), refusal.what.data() + refusal.what.size(), code);
  return code;
}

std::uint8_t code(ModbusException exception) { return static_cast<std::uint8_t>(exception); }

bool is_silent(const ServedRegisters& registers) { return registers.is_silent_on_errors(); }

void append(std::vector<std::byte>& to, const std::vector<std::byte>& bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

/// Registers that are consecutive on the served link and in the register map.
struct Run {
  std::uint16_t address{}, count{};
};

/// Splits `count` registers from `address` on into runs. Returns nothing if one of the registers does not exist on the
/// link.
std::optional<std::vector<Run>> split_runs(const LinkAddresses& addresses, std::uint16_t address, std::uint16_t count) {
  if (address + count > 0x10000) return std::nullopt;
  std::vector<Run> runs;
  for (std::uint16_t i = 0; i < count; ++i) {
    const auto at = addresses.to_selected_link(static_cast<std::uint16_t>(address + i));
    if (!at) return std::nullopt;
    if (!runs.empty() && runs.back().address + runs.back().count == *at)
      ++runs.back().count;
    else
      runs.push_back({*at, 1});
  }
  return runs;
}

tl::expected<void, ModbusException> read_registers(const ServedRegisters& registers, const LinkAddresses& addresses,
                                                   const drivers::ModbusRequest& request,
                                                   std::vector<std::uint16_t>& words) {
  if (request.count == 0 || request.count > addresses.read_at_most())
    return tl::unexpected(ModbusException::illegal_value);
  const auto runs = split_runs(addresses, request.address, request.count);
  if (!runs) return tl::unexpected(ModbusException::illegal_address);
  for (const auto& run : *runs)
    if (auto done = registers.read(static_cast<drivers::ReadFunction>(request.function), run.address, run.count, words);
        !done)
      return done;
  return {};
}

/// Writes all registers or none. Registers that are not consecutive in the register map cannot be written together.
tl::expected<void, ModbusException> write_registers(ServedRegisters& registers, const LinkAddresses& addresses,
                                                    drivers::WriteFunction function,
                                                    const drivers::ModbusRequest& request) {
  if (request.words.empty()) return tl::unexpected(ModbusException::illegal_value);
  const auto runs = split_runs(addresses, request.address, static_cast<std::uint16_t>(request.words.size()));
  if (!runs || runs->size() != 1) return tl::unexpected(ModbusException::illegal_address);
  return registers.write(function, runs->front().address, request.words);
}

}  // namespace

LinkAddresses::LinkAddresses(const drivers::RegisterMap& map, drivers::LinkKind kind) {
  const auto* link = map.find(kind);
  if (!link) link = &map.link;
  link_ = link->modbus;
  if ((link->kind == drivers::LinkKind::tcp) == (map.link.kind == drivers::LinkKind::tcp)) return;
  for (const auto& item : map.items) {
    // Here rtu_address is the address on the link that is not selected, be it RTU or TCP.
    if (!item.rtu_address) continue;
    for (std::uint16_t i = 0; i < word_count(item); ++i) {
      moved_[static_cast<std::uint16_t>(*item.rtu_address + i)] = static_cast<std::uint16_t>(item.address + i);
      away_.insert(static_cast<std::uint16_t>(item.address + i));
    }
  }
}

std::optional<std::uint16_t> LinkAddresses::to_selected_link(std::uint16_t address) const {
  if (const auto moved = moved_.find(address); moved != moved_.end()) return moved->second;
  return away_.contains(address) ? std::nullopt : std::optional(address);
}

tl::expected<void, ModbusException> carry_out(ServedRegisters& registers, const LinkAddresses& addresses,
                                              const drivers::ModbusRequest& request,
                                              std::vector<std::uint16_t>& words) {
  switch (request.function) {
    case drivers::ModbusFunction::read_coils:
    case drivers::ModbusFunction::read_discrete_inputs:
      return registers.read(static_cast<drivers::ReadFunction>(request.function), request.address, request.count,
                            words);
    case drivers::ModbusFunction::read_holding:
    case drivers::ModbusFunction::read_input: return read_registers(registers, addresses, request, words);
    case drivers::ModbusFunction::write_coil:
      return registers.write(drivers::WriteFunction::coil, request.address, request.words);
    case drivers::ModbusFunction::write_single:
      return write_registers(registers, addresses, drivers::WriteFunction::one_register, request);
    case drivers::ModbusFunction::write_multiple:
      return write_registers(registers, addresses, drivers::WriteFunction::registers, request);
    case drivers::ModbusFunction::loop_back: return {};
  }
  return tl::unexpected(ModbusException::illegal_function);
}

bool ModbusSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  std::span<const std::byte> rest(pending_);
  while (true) {
    const auto length = drivers::frame_length(rest);
    if (!length) return false;
    if (!*length) break;
    const auto frame = rest.first(**length);
    if (std::to_integer<std::uint8_t>(frame[kUnitOffset]) == addresses_.unit()) append(reply, answer(frame));
    rest = rest.subspan(**length);
  }
  pending_.erase(pending_.begin(), pending_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return true;
}

std::vector<std::byte> ModbusSession::answer(std::span<const std::byte> frame) {
  const auto request = drivers::decode_request(frame);
  const auto refuse = [&](std::uint8_t exception) {
    return is_silent(registers_) ? std::vector<std::byte>() : drivers::encode_exception(frame, exception);
  };
  if (!request) return refuse(exception_code(request.error()));
  if (request->function == drivers::ModbusFunction::loop_back) return refuse(code(ModbusException::illegal_function));
  words_.clear();
  if (const auto done = carry_out(registers_, addresses_, *request, words_); !done) return refuse(code(done.error()));
  return drivers::encode_reply(*request, words_);
}

bool ModbusRtuSession::feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  std::span<const std::byte> rest(pending_);
  while (!rest.empty()) {
    const auto size = drivers::rtu_request_size(rest);
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
  if (std::to_integer<std::uint8_t>(frame.front()) != addresses_.unit()) return;
  const auto request = drivers::decode_rtu_request(frame);
  if (!request && request.error().kind == FaultKind::corrupted) return;
  const auto refuse = [&](std::uint8_t exception) {
    if (!is_silent(registers_)) append(reply, drivers::encode_rtu_exception(frame, exception));
  };
  if (!request) return refuse(exception_code(request.error()));
  words_.clear();
  if (const auto done = carry_out(registers_, addresses_, *request, words_); !done) return refuse(code(done.error()));
  append(reply, drivers::encode_rtu_reply(*request, words_));
}

std::unique_ptr<Session> make_modbus_session(ServedRegisters& registers) {
  if (registers.map().link.kind == drivers::LinkKind::tcp) return std::make_unique<ModbusSession>(registers);
  return std::make_unique<ModbusRtuSession>(registers, registers.map().link.kind);
}

}  // namespace gyrotherm::simulator
