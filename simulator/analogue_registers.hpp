// SPDX-License-Identifier: Apache-2.0
/// A virtual unit of analogue inputs as its register map shows it: what the world's units tell of themselves, on its
/// inputs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "core/result.hpp"
#include "drivers/analogue/modbus_analogue_input.hpp"
#include "simulator/served_registers.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// What is wired to an input: a value of a unit of the world, through a transducer that makes (value − offset) / scale
/// of it.
struct WiredInput {
  std::size_t input{};  ///< its place in the map
  std::string unit;     ///< of the world
  std::string value;    ///< VirtualLaboratory::values, by name
  double scale = 1;
  double offset = 0;
};

struct VirtualAnalogueInput {
  drivers::AnalogueMap map;
  std::vector<WiredInput> inputs;  ///< of two on one input the first counts
};

/// Serves the inputs from the world, every status register with its code "normal", the map's fingerprint, and zeros
/// elsewhere. An input to which nothing is wired shows what a register of zeros means. Nothing can be written.
class AnalogueRegisters final : public ServedRegisters {
 public:
  /// `laboratory` must outlive this. Fails with usage if a unit or a value is not the world's, or the map has not that
  /// input.
  [[nodiscard]] static Result<AnalogueRegisters> make(VirtualAnalogueInput wired, const VirtualLaboratory& laboratory);

  [[nodiscard]] const drivers::RegisterMap& map() const override { return map_.registers; }
  /// Each table by its own functions; a register by that of its item. Where the map says `holes`, what lies between
  /// its items reads 0.
  [[nodiscard]] tl::expected<void, ModbusException> read(drivers::ReadFunction function, std::uint16_t address,
                                                         std::uint16_t count,
                                                         std::vector<std::uint16_t>& words) const override;
  [[nodiscard]] tl::expected<void, ModbusException> write(drivers::WriteFunction, std::uint16_t,
                                                          std::span<const std::uint16_t>) override {
    return tl::unexpected(ModbusException::illegal_address);
  }
  /// The laboratory is there now, as after it was moved.
  void watch(const VirtualLaboratory& laboratory) { laboratory_ = &laboratory; }

 private:
  /// Where in the world an input's value is, and how the input shows it.
  struct Source {
    std::size_t unit{}, value{};
    double scale = 1, offset = 0;
  };

  AnalogueRegisters(drivers::AnalogueMap map, std::map<std::string, Source> sources,
                    const VirtualLaboratory& laboratory)
      : map_(std::move(map)), sources_(std::move(sources)), laboratory_(&laboratory) {}

  [[nodiscard]] std::vector<std::uint16_t> words_of(const drivers::RegisterItem& item) const;

  drivers::AnalogueMap map_;
  std::map<std::string, Source> sources_;  ///< by the item of the input
  const VirtualLaboratory* laboratory_;
};

}  // namespace gyrotherm::simulator
