/// What sensors an MCC USB-TEMP or USB-TC can be told that it has, as requests.
#pragma once

#include <array>
#include <cstdint>
#include <variant>
#include <vector>

#include "drivers/thermometer/mcc_usb_temp_codec.hpp"

namespace gyrotherm {

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

}  // namespace gyrotherm
