/// The virtual chamber as its register map shows it.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/chamber/register_map.hpp"
#include "simulator/memory_image.hpp"
#include "simulator/program_run.hpp"
#include "simulator/register_image.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm {

/// Codes of a Modbus exception reply (Modbus Application Protocol V1.1b3, section 7).
enum class ModbusException : std::uint8_t { illegal_function = 1, illegal_address = 2, illegal_value = 3 };

/// Serves air_temperature, set_point (and active_ or working_set_point), output and clocks from the world; what
/// switches the chamber on, starts its program and shows its state is for the map's [simulated] table to say. A map in
/// which nothing switches it on describes a chamber that is on. Any other item keeps what is written to it.
class ChamberRegisters {
 public:
  /// `world` must outlive this.
  ChamberRegisters(RegisterMap map, VirtualLaboratory& laboratory);
  ChamberRegisters(const ChamberRegisters&) = delete;  // live_ points into map_

  [[nodiscard]] const RegisterMap& map() const { return map_; }
  [[nodiscard]] std::uint8_t unit() const { return map_.link.modbus.unit; }

  /// Appends `count` words to `words`. Fails with illegal_value if the map reads fewer at once, or illegal_address at a
  /// register that is none of the map's (inside a map's one block such a hole reads 0).
  [[nodiscard]] tl::expected<void, ModbusException> read(ReadFunction function, std::uint16_t address,
                                                         std::uint16_t count, std::vector<std::uint16_t>& words) const;
  /// All or nothing. Fails with illegal_address at a register that is not writable or belongs to an item written in
  /// part, or illegal_value if the controller does not accept what is written.
  [[nodiscard]] tl::expected<void, ModbusException> write(WriteFunction function, std::uint16_t address,
                                                          std::span<const std::uint16_t> words);

  /// The second that begins: a program that runs has its set point in it. To be called before the world's step.
  void pass_second();
  [[nodiscard]] const ProgramRun& program() const { return run_; }

 private:
  enum class Role { air, set_point, output, mode, clock, shows, sentinel };
  struct Live {
    const RegisterItem* item{};
    Role role{};
    const SimulatedUnit::Shows* shows{};
  };
  struct Assignment {
    const RegisterItem* item{};  ///< nothing: a word of the profile memory
    int address{};
    std::vector<std::uint16_t> words;
    double value{};
  };

  void find_live_items();
  void find_addresses();
  [[nodiscard]] bool serves(int address) const;
  [[nodiscard]] std::vector<std::uint16_t> live_words(const Live& live) const;
  [[nodiscard]] double shown(const SimulatedUnit::Shows& shows) const;
  [[nodiscard]] tl::expected<Assignment, ModbusException> assignment(int address, std::span<const std::uint16_t> words,
                                                                     bool coil) const;
  [[nodiscard]] bool accepts(const RegisterItem& item, double value) const;
  void apply(const Assignment& assignment);
  void take_effect(const RegisterItem& item, double value);
  void start_program();

  RegisterMap map_;
  VirtualLaboratory& laboratory_;
  RegisterImage image_;
  MemoryImage memory_;
  ProgramRun run_;
  std::vector<Live> live_;
  std::map<int, bool> served_;     ///< addresses of items
  int hole_begin_{}, hole_end_{};  ///< of the map's one block, or of all that it has; empty if it has no holes
  std::int64_t seconds_{};
};

}  // namespace gyrotherm
