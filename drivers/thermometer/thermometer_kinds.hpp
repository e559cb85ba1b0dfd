// SPDX-License-Identifier: Apache-2.0
/// Table of the supported kinds of thermometers. A new kind needs a row here and its driver.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/thermometer/dcon_thermometer.hpp"
#include "drivers/thermometer/lakeshore_218.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "drivers/thermometer/process_thermometer.hpp"
#include "drivers/thermometer/pt12.hpp"
#include "drivers/thermometer/thermometer_description.hpp"

namespace gyrotherm::drivers {

enum class ThermometerKind { lakeshore_218, dcon, pt12, mcc_usb_temp, process, text };

/// Makes an instrument that has no settings except its line. If `simulated`, the pauses that only a real instrument
/// needs are omitted.
using MakeOnLine = std::unique_ptr<Thermometer> (*)(std::unique_ptr<ByteStream> line, std::string place,
                                                    const Clock* clock, bool simulated);
template <class Timing, auto make>
std::unique_ptr<Thermometer> make_on_line(std::unique_ptr<ByteStream> line, std::string place, const Clock* clock,
                                          bool simulated) {
  Timing timing{.clock = clock};
  if (simulated) timing.pause = {};
  return make(std::move(line), std::move(place), timing);
}

struct ThermometerKindRow {
  ThermometerKind kind{};
  /// Name in rig files: driver = "…".
  const char* name = "";
  /// Inputs of one instrument, or of one module on a line; the most if a description or a program states them.
  std::size_t inputs{};
  /// Serial format if the rig file does not specify one: the factory setting, or the only format of the instrument.
  SerialFormat serial{};
  /// Null for a kind with its own settings. The reader of rig files then makes the instrument.
  MakeOnLine make = nullptr;
};

inline constexpr std::array kThermometerKinds{
    ThermometerKindRow{.kind = ThermometerKind::lakeshore_218,
                       .name = "lakeshore_218",
                       .inputs = kLakeshore218Inputs,
                       .serial = {.baud = 9600, .data_bits = 7, .parity = SerialParity::odd, .stop_bits = 1},
                       .make = make_on_line<Lakeshore218Timing, make_lakeshore_218>},
    ThermometerKindRow{.kind = ThermometerKind::dcon, .name = "dcon", .inputs = kDconInputs},
    ThermometerKindRow{.kind = ThermometerKind::pt12,
                       .name = "pt12",
                       .inputs = kPt12Inputs,
                       .make = make_on_line<Pt12Timing, make_pt12>},
    ThermometerKindRow{.kind = ThermometerKind::mcc_usb_temp, .name = "mcc_usb_temp", .inputs = kMccInputs},
    ThermometerKindRow{.kind = ThermometerKind::process, .name = "process", .inputs = kMostProcessInputs},
    ThermometerKindRow{.kind = ThermometerKind::text, .name = "text", .inputs = kMostTextInputs},
};

/// Returns the row of a kind. Requires that the rows are in the order of the kinds.
[[nodiscard]] constexpr const ThermometerKindRow& kind_row(ThermometerKind kind) {
  return kThermometerKinds[static_cast<std::size_t>(kind)];
}

/// Keywords for `driver` in a rig file.
inline constexpr Vocabulary<ThermometerKind, kThermometerKinds.size()> kThermometerDrivers = [] {
  Vocabulary<ThermometerKind, kThermometerKinds.size()> words{};
  for (std::size_t i = 0; i < words.size(); ++i) {
    words[i].first = kThermometerKinds[i].name;
    words[i].second = kThermometerKinds[i].kind;
  }
  return words;
}();

}  // namespace gyrotherm::drivers
