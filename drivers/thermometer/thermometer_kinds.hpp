// SPDX-License-Identifier: Apache-2.0
/// The kinds of thermometers that gyrotherm has drivers for: one table. A new one is a row here, and its driver.
#pragma once

#include <array>
#include <cstddef>

#include "core/toml_reader.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/thermometer/dcon_thermometer.hpp"
#include "drivers/thermometer/lakeshore_218.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "drivers/thermometer/pt12.hpp"

namespace gyrotherm::drivers {

enum class ThermometerKind { lakeshore_218, dcon, pt12, mcc_usb_temp };

struct ThermometerKindRow {
  ThermometerKind kind{};
  const char* name = "";  ///< as rig files spell it: driver = "…"
  std::size_t inputs{};   ///< inputs of one instrument, or of one module on a line
  SerialFormat serial{};  ///< where the line does not say it: as delivered, or fixed by the manual
};

inline constexpr std::array kThermometerKinds{
    ThermometerKindRow{.kind = ThermometerKind::lakeshore_218,
                       .name = "lakeshore_218",
                       .inputs = kLakeshore218Inputs,
                       .serial = {.baud = 9600, .data_bits = 7, .parity = SerialParity::odd, .stop_bits = 1}},
    ThermometerKindRow{.kind = ThermometerKind::dcon, .name = "dcon", .inputs = kDconInputs},
    ThermometerKindRow{.kind = ThermometerKind::pt12, .name = "pt12", .inputs = kPt12Inputs},
    ThermometerKindRow{.kind = ThermometerKind::mcc_usb_temp, .name = "mcc_usb_temp", .inputs = kMccInputs},
};

/// The row of a kind; rows stand in the order of the kinds.
[[nodiscard]] constexpr const ThermometerKindRow& row_of(ThermometerKind kind) {
  return kThermometerKinds[static_cast<std::size_t>(kind)];
}

/// The words of a rig file's `driver`.
inline constexpr Vocabulary<ThermometerKind, kThermometerKinds.size()> kThermometerDrivers = [] {
  Vocabulary<ThermometerKind, kThermometerKinds.size()> words{};
  for (std::size_t i = 0; i < words.size(); ++i) {
    words[i].first = kThermometerKinds[i].name;
    words[i].second = kThermometerKinds[i].kind;
  }
  return words;
}();

}  // namespace gyrotherm::drivers
