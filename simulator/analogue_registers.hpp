// SPDX-License-Identifier: Apache-2.0
/// A virtual analogue input module, accessed through its register map. Its inputs carry values that the simulated units
/// report.
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

/// A value of a simulated unit that is wired to an input through a transducer. The input receives (value − offset) /
/// scale.
struct WiredInput {
  /// Position in the map's list of inputs.
  std::size_t input{};
  /// Name of the unit, and of one of its VirtualLaboratory::values.
  std::string unit;
  std::string value;
  double scale = 1;
  double offset = 0;
};

struct VirtualAnalogueInput {
  drivers::AnalogueMap map;
  /// If two are wired to the same input, the first one is used.
  std::vector<WiredInput> inputs;
};

/// Serves the wired values, the code "normal" in every status register, the map's fingerprint, and zeros elsewhere. An
/// input without a wired value shows the value of a zero register. All registers are read-only.
class AnalogueRegisters final : public ServedRegisters {
 public:
  /// Creates the registers. `laboratory` must outlive them. Fails with usage if the laboratory does not have a named
  /// unit or value, or if the map does not have a wired input.
  [[nodiscard]] static Result<AnalogueRegisters> make(VirtualAnalogueInput wired, const VirtualLaboratory& laboratory);

  [[nodiscard]] const drivers::RegisterMap& map() const override { return map_.registers; }
  /// Reads registers. Each item can be read only by the read function that the map states for it. If the map has
  /// `holes`, registers between its items read 0.
  [[nodiscard]] tl::expected<void, ModbusException> read(drivers::ReadFunction function, std::uint16_t address,
                                                         std::uint16_t count,
                                                         std::vector<std::uint16_t>& words) const override;
  [[nodiscard]] tl::expected<void, ModbusException> write(drivers::WriteFunction, std::uint16_t,
                                                          std::span<const std::uint16_t>) override {
    return tl::unexpected(ModbusException::illegal_address);
  }
  /// Updates the reference after the laboratory object was moved.
  void watch(const VirtualLaboratory& laboratory) { laboratory_ = &laboratory; }

 private:
  /// Indices of the unit and of its value in the laboratory, and the transducer's scale and offset.
  struct Source {
    std::size_t unit{}, value{};
    double scale = 1, offset = 0;
  };

  AnalogueRegisters(drivers::AnalogueMap map, std::map<std::string, Source> sources,
                    const VirtualLaboratory& laboratory)
      : map_(std::move(map)), sources_(std::move(sources)), laboratory_(&laboratory) {}

  [[nodiscard]] std::vector<std::uint16_t> encode_words(const drivers::RegisterItem& item) const;

  drivers::AnalogueMap map_;
  std::map<std::string, Source> sources_;
  const VirtualLaboratory* laboratory_;
};

}  // namespace gyrotherm::simulator
