// SPDX-License-Identifier: Apache-2.0
/// The side of virtual thermocouple modules that speak DCON (I-7018 user's manual rev. B1.0, chapters 1.10 and 2).
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/thermometer/dcon_codec.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// One module, as it is set.
struct DconModule {
  std::uint8_t address = 1;
  std::uint8_t type = 0x10;  ///< of its thermocouples: 0E, 0F, 10 or 11 for J, K, T, E
  drivers::DconChecksum checksum = drivers::DconChecksum::off;
  Inputs<drivers::kDconInputs> inputs;
};

/// Modules on one line. Each answers #AA and #AAN in engineering units with two decimals, $AA2, $AA6, $AAM and $AAF at
/// its address; another command after $AA is invalid (?AA); anything else has no reply. An input without a thermometer
/// is an open wire: over range.
class DconSession final : public TextSession {
 public:
  /// `world` must outlive this.
  DconSession(const VirtualLaboratory& laboratory, std::vector<DconModule> modules)
      : TextSession('\r'), laboratory_(laboratory), modules_(std::move(modules)) {}

 private:
  [[nodiscard]] std::string answer(std::string_view command) const override;
  [[nodiscard]] std::string answer(const DconModule& module, std::string_view command) const;
  [[nodiscard]] std::string readings(const DconModule& module, std::string_view which) const;

  const VirtualLaboratory& laboratory_;
  std::vector<DconModule> modules_;
};

}  // namespace gyrotherm::simulator
