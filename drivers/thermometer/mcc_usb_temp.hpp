// SPDX-License-Identifier: Apache-2.0
/// What sensors an MCC USB-TEMP or USB-TC can be told that it has, as requests.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/clock.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/hid_line.hpp"
#include "drivers/thermometer/mcc_usb_temp_codec.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Two sensors per converter are possible with two_wire_two_sensors and four_wire alone.
enum class MccWires : std::uint8_t { two_wire_one_sensor, two_wire_two_sensors, three_wire, four_wire };
enum class MccThermocoupleType : std::uint8_t { j, k, t, e, r, s, b, n };

/// Platinum resistance, Callendar–Van Dusen (IEC 60751): R/R0 = 1 + A t + B t² + C (t − 100 °C) t³, C for t < 0 alone.
/// The default is the standard's sensor of 100 Ω.
struct MccRtd {
  MccWires wires = MccWires::two_wire_two_sensors;
  float r0_ohm = 100, a_per_k = 3.9083e-3f, b_per_k2 = -5.775e-7f, c_per_k4 = -4.183e-12f;
};
/// Steinhart–Hart: 1/T = a + b ln R + c (ln R)³, T in K, R in Ω.
struct MccThermistor {
  MccWires wires = MccWires::two_wire_two_sensors;
  float a{}, b{}, c{};
};
/// A voltage that is linear in the temperature.
struct MccSemiconductor {
  bool differential{};
  float offset{}, scale{};
};
struct MccThermocouple {
  MccThermocoupleType type{};
};
using MccSensor = std::variant<MccRtd, MccThermistor, MccSemiconductor, MccThermocouple>;

/// Makes `sensor` the one at `input`. The two inputs of a converter (0 and 1, 2 and 3, …) share the kind of sensor and
/// its wires. After the last input the instrument must calibrate (MccCommand::calibrate).
[[nodiscard]] std::vector<MccRequest> mcc_setup(std::uint8_t input, const MccSensor& sensor);

/// What the sensor can report: the reference tables of IEC 60751 and IEC 60584-1; for the others from absolute zero to
/// 200 °C, above every chamber.
[[nodiscard]] TemperatureRange mcc_range(const MccSensor& sensor);

/// The rates of the converters' filter, by its code from 1 to F.
inline constexpr std::array kMccFilterHz{500.0, 250.0, 125.0, 62.5, 50.0, 39.2, 33.3, 19.6,
                                         16.7,  16.7,  12.5,  10.0, 8.33, 6.25, 4.17};

// MCC USB-TEMP and USB-TC: eight thermometers over HID.

inline constexpr std::array<HidKind, 2> kMccKinds{{{0x09DB, 0x008D, "USB-TEMP"}, {0x09DB, 0x0090, "USB-TC"}}};

struct MccOptions {
  /// What is connected to each input; nothing: the instrument is not told and not asked, and any temperature between
  /// absolute zero and the end of type B may be true.
  std::array<std::optional<MccSensor>, kMccInputs> sensors{};
  Duration within = std::chrono::milliseconds(500);  ///< for a reply; after one that did not come, silence as long
  const Clock* clock = nullptr;                      ///< of a device with a time of its own
};

/// Whenever the instrument was opened, and before it is read, its set-up is compared with `sensors`; where it differs
/// it is set, and the instrument calibrates itself, which takes some seconds, in which read() yields a timeout in every
/// place and identify() waits. Then the set-up is compared again; mismatch if it does not hold it. `place` names the
/// instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_mcc_usb_temp(std::unique_ptr<HidReports> reports, std::string place,
                                                             MccOptions options = {});

}  // namespace gyrotherm::drivers
