/// A thermocouple module of the DCON family (ADAM-4018/4018+, ICP DAS I-7018, ADLINK 6018): eight thermometers.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/instruments.hpp"
#include "drivers/thermometer/dcon_codec.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

struct DconOptions {
  std::uint8_t address = 1;
  DconChecksum checksum = DconChecksum::off;         ///< as the module is set
  Duration within = std::chrono::milliseconds(500);  ///< for a whole answer; to a wrong address none comes
  Duration pause = std::chrono::milliseconds(10);    ///< the line must be silent this long before a question
};

/// One module, alone on its line. Before the first reading, and again after each failure to answer, the module is asked
/// how it is set: mismatch if not to engineering units and thermocouples J, K, T or E. `place` names the instrument in
/// its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_dcon_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                                 DconOptions options = {});

}  // namespace gyrotherm
