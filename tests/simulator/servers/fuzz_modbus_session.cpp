// SPDX-License-Identifier: Apache-2.0
/// Feeds any bytes in any pieces to the virtual chamber. The set point must remain in the range of the plant.
#include <cstdlib>

#include "simulator/chamber_registers.hpp"
#include "simulator/servers/modbus_server.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::simulator {

FUZZ_TARGET(modbus_session, const std::uint8_t* data, std::size_t size) {
  static VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  static ChamberRegisters registers(chamber_map("virtual"), laboratory);
  ModbusSession session(registers);
  std::vector<std::byte> reply;
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto first_piece = size / 3;
  if (session.feed(bytes.first(first_piece), reply)) (void)session.feed(bytes.subspan(first_piece), reply);
  if (!laboratory.accepts(laboratory.set_point())) std::abort();

  // Also sends the bytes as the body of a valid frame, which reaches the code behind the header check.
  const auto body = bytes.first(std::min<std::size_t>(size, 252));
  std::vector<std::byte> frame{std::byte{0}, std::byte{1},
                               std::byte{0}, std::byte{0},
                               std::byte{0}, static_cast<std::byte>(body.size() + 2),
                               std::byte{1}, std::byte{size % 2 == 0 ? std::uint8_t{16} : std::uint8_t{3}}};
  frame.insert(frame.end(), body.begin(), body.end());
  if (!ModbusSession(registers).feed(frame, reply)) std::abort();
  if (!laboratory.accepts(laboratory.set_point())) std::abort();
  return 0;
}

}  // namespace gyrotherm::simulator
