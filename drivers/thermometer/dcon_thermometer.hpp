// SPDX-License-Identifier: Apache-2.0
/// Thermocouple modules of the DCON family (ADAM-4018/4018+, ICP DAS I-7018, ADLINK 6018): eight thermometers each.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "drivers/instruments.hpp"
#include "drivers/thermometer/dcon_codec.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

struct DconOptions {
  std::uint8_t address = 1;
  DconChecksum checksum = DconChecksum::off;         ///< as the module is set
  std::optional<std::uint8_t> type{};                ///< that all its inputs must be set to; any without it
  Duration within = std::chrono::milliseconds(500);  ///< for a whole answer; to a wrong address none comes
  Duration pause = std::chrono::milliseconds(10);    ///< the line must be silent this long before a question
  const Clock* clock = nullptr;                      ///< of a line with a time of its own
};

/// One module, alone on its line. Before the first reading, and again after each failure to answer, the module is asked
/// how it is set: mismatch if not to engineering units and thermocouples J, K, T or E (or to `type`, if that is given).
/// `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_dcon_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                                 DconOptions options = {});

/// Modules that share one line, at these addresses, as one thermometer: the inputs of the first, then those of the
/// next, and so on. They are asked one after the other. A module that does not answer twice in a row rests 0.5 s, then
/// longer, up to 10 s, and its inputs are faults until then; while it is tried the others' readings come later by up to
/// twice `within`.
[[nodiscard]] std::unique_ptr<Thermometer> make_dcon_modules(std::unique_ptr<ByteStream> line, const std::string& place,
                                                             const std::vector<std::uint8_t>& addresses,
                                                             const DconOptions& options = {});

}  // namespace gyrotherm::drivers
