/// The virtual chamber as its register map shows it.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/chamber/register_map.hpp"
#include "simulator/world.hpp"

namespace gyrotherm {

/// Codes of a Modbus exception reply (Modbus Application Protocol V1.1b3, section 7).
enum class ModbusException : std::uint8_t { illegal_function = 1, illegal_address = 2, illegal_value = 3 };

/// Serves the items air_temperature, set_point, output, the control mode and the fingerprint from the world; any other
/// item of the map reads 0 and keeps nothing that is written to it.
class ChamberRegisters {
 public:
  /// `world` must outlive this.
  ChamberRegisters(RegisterMap map, World& world);
  ChamberRegisters(const ChamberRegisters&) = delete;  // entries_ points into map_

  [[nodiscard]] std::uint8_t unit() const { return map_.unit; }
  /// Appends `count` registers to `words`. Fails with illegal_value if the map reads fewer at once, or illegal_address
  /// at a register that is none of the map's (inside a map's one block such a hole reads 0).
  [[nodiscard]] tl::expected<void, ModbusException> read(std::uint16_t address, std::uint16_t count,
                                                         std::vector<std::uint16_t>& words) const;
  /// All or nothing. Fails with illegal_address at a register that is not writable or belongs to an item written in
  /// part, or illegal_value if the controller does not accept what is written.
  [[nodiscard]] tl::expected<void, ModbusException> write(std::uint16_t address, std::span<const std::uint16_t> words);

 private:
  enum class Meaning { air, set_point, output, mode, fingerprint, nothing };
  struct Entry {
    const RegisterItem* item{};
    Meaning meaning{};
    std::size_t word{};  ///< which of the item's
  };
  struct Assignment {
    Meaning meaning{};
    double value{};
  };

  [[nodiscard]] Meaning meaning_of(const RegisterItem& item) const;
  [[nodiscard]] bool is_hole_of_block(std::uint16_t address) const;
  [[nodiscard]] double value(Meaning meaning) const;
  [[nodiscard]] bool accepts(const Assignment& assignment) const;
  void apply(const Assignment& assignment);

  RegisterMap map_;
  World& world_;
  std::map<int, Entry> entries_;  ///< by address
  int block_begin_{};             ///< of the map's one block; empty if it has none
  int block_end_{};
};

}  // namespace gyrotherm
