/// The virtual chamber's side of Modbus TCP: functions 3, 4, 6 and 16 over the registers of its map.
#pragma once

#include "simulator/chamber_registers.hpp"
#include "simulator/session.hpp"

namespace gyrotherm {

/// Function 4 reads the same registers as 3. Requests to another unit are not answered, as by a unit on a shared line.
/// Bytes that cannot become a frame end the session.
class ModbusSession final : public Session {
 public:
  /// `registers` must outlive this.
  explicit ModbusSession(ChamberRegisters& registers) : registers_(registers) {}
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) override;

 private:
  [[nodiscard]] std::vector<std::byte> answer(std::span<const std::byte> frame);

  ChamberRegisters& registers_;
  std::vector<std::byte> pending_;    ///< the beginning of a frame
  std::vector<std::uint16_t> words_;  ///< of one reply, kept for its memory
};

}  // namespace gyrotherm
