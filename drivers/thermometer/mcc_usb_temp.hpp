// SPDX-License-Identifier: Apache-2.0
/// MCC USB-TEMP and USB-TC, eight inputs over HID: the encoding for host and instrument (formats of the vendor's public
/// library uldaq 1.2.1 and of the USB-TEMP specification), the supported sensors, and the driver.
///
/// A request is one output report whose byte 0 is its command; a reply is one input report with the same byte 0.
/// Integers and numbers (IEEE-754 binary32) are little-endian. Reports may have additional bytes at the end, because
/// some systems pad them. Reports that write memory or firmware are not supported.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/hid_line.hpp"
#include "drivers/thermometer/placed_readings.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kMccInputs = 8;
inline constexpr std::size_t kMccLongestReport = 64;

enum class MccCommand : std::uint8_t {
  read_input = 0x18,
  scan = 0x19,
  read_memory = 0x30,
  read_status = 0x44,
  set_item = 0x49,
  read_item = 0x4A,
  calibrate = 0x4B,
};

/// Settings of an input. The two inputs of a converter (0 and 1, 2 and 3, …) share the items before `thermocouple`; the
/// other items exist once per input. `reference_v` and the coefficients are numbers, all other items are bytes.
enum class MccItem : std::uint8_t {
  sensor = 0x00,
  connection = 0x01,
  filter = 0x02,
  excitation = 0x03,
  reference_v = 0x04,
  thermocouple = 0x10,
  gain = 0x12,
  coefficient_0 = 0x14,
  coefficient_1 = 0x16,
  coefficient_2 = 0x18,
  coefficient_3 = 0x1A,
};

/// Units of a reading. Raw values are in V or Ω, depending on the sensor.
enum class MccUnits : std::uint8_t { celsius = 0, raw = 1 };

/// Input numbers of the cold junctions, which scans do not include. The other inputs are 0 to 7.
inline constexpr std::uint8_t kMccColdJunction0 = 0x80, kMccColdJunction1 = 0x81;

/// Special values in place of a temperature.
inline constexpr float kMccOpen = -8888, kMccNotReady = -9000, kMccDisabled = -9999;

struct MccRequest {
  MccCommand command{};
  std::vector<std::uint8_t> arguments;
  bool operator==(const MccRequest&) const = default;
};

/// Makes a request. `arguments` are the bytes after the command, as on the wire.
[[nodiscard]] MccRequest mcc_request(MccCommand command, std::initializer_list<std::uint8_t> arguments = {});
[[nodiscard]] MccRequest mcc_read_input(std::uint8_t input, MccUnits units = MccUnits::celsius);
[[nodiscard]] MccRequest mcc_scan(std::uint8_t first, std::uint8_t last, MccUnits units = MccUnits::celsius);
/// Requests `count` bytes, at most 62, of the 256-byte user memory.
[[nodiscard]] MccRequest mcc_read_memory(std::uint8_t address, std::uint8_t count);
[[nodiscard]] MccRequest mcc_read_item(std::uint8_t input, MccItem item);
[[nodiscard]] MccRequest mcc_set_item(std::uint8_t input, MccItem item, std::uint8_t value);
[[nodiscard]] MccRequest mcc_set_item(std::uint8_t input, MccItem item, float value);
/// Requests the date of the last calibration.
[[nodiscard]] inline MccRequest mcc_read_calibration_date() { return mcc_read_memory(0xF0, 6); }

/// Encodes a request in its shortest form. The caller must append a zero to a one-byte report, because hidraw refuses
/// such reports.
[[nodiscard]] std::vector<std::byte> encode_mcc_request(const MccRequest& request);
/// Instrument: decodes a request, which may be followed by zeros. Fails with corrupted (unknown command, wrong length)
/// or refused (an argument that the instrument does not support).
[[nodiscard]] Result<MccRequest> decode_mcc_request(std::span<const std::byte> report);

/// Returns the number of bytes after byte 0 in the reply to `request`; 0 if there is no reply.
[[nodiscard]] std::size_t mcc_reply_length(const MccRequest& request);
/// Decodes a reply that consists of bytes (memory, status, or a byte item) and returns the bytes after byte 0. Fails
/// with corrupted if the report belongs to another command or is too short.
[[nodiscard]] Result<std::vector<std::uint8_t>> decode_mcc_bytes(const MccRequest& request,
                                                                 std::span<const std::byte> report);
/// Decodes a reply that consists of numbers: raw inputs, or a number item. Fails as decode_mcc_bytes() does.
[[nodiscard]] Result<std::vector<float>> decode_mcc_numbers(const MccRequest& request,
                                                            std::span<const std::byte> report);

using MccRanges = std::array<TemperatureRange, kMccInputs>;
/// Range of an input with an unknown sensor: absolute zero to the upper end of thermocouple B.
inline constexpr TemperatureRange kMccMaxRange{{-273.15}, {1820}};
[[nodiscard]] constexpr MccRanges mcc_max_ranges() {
  MccRanges ranges{};
  ranges.fill(kMccMaxRange);
  return ranges;
}

/// Decodes the temperatures of a scan or a single input, requested in °C. Fails with corrupted. An input that is open,
/// not ready, disabled or outside its range has a fault (out_of_range).
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_mcc_temperatures(const MccRequest& request,
                                                                           std::span<const std::byte> report,
                                                                           const MccRanges& ranges = mcc_max_ranges());

/// Returns whether a self-calibration is in progress, during which readings do not change and items cannot be set.
[[nodiscard]] constexpr bool is_mcc_calibrating(std::uint8_t status) { return (status & 1) != 0; }

/// Decodes six bytes of memory: year − 2000, month, day, hour, minute, second, in an unknown time zone. Fails with
/// corrupted for an invalid time.
[[nodiscard]] Result<std::chrono::local_seconds> decode_mcc_date(std::span<const std::uint8_t> bytes);

/// Instrument: encodes a reply.
[[nodiscard]] std::vector<std::byte> encode_mcc_bytes(MccCommand command, std::span<const std::uint8_t> bytes);
[[nodiscard]] std::vector<std::byte> encode_mcc_numbers(MccCommand command, std::span<const float> numbers);

/// Wiring of a converter. Only two_wire_two_sensors and four_wire allow two sensors per converter.
enum class MccWires : std::uint8_t { two_wire_one_sensor, two_wire_two_sensors, three_wire, four_wire };
enum class MccThermocoupleType : std::uint8_t { j, k, t, e, r, s, b, n };

/// Platinum resistance thermometer, by the Callendar–Van Dusen equation (IEC 60751): R/R0 = 1 + A t + B t² + C (t − 100
/// °C) t³, with C only for t < 0. The default is the standard 100 Ω sensor.
struct MccRtd {
  MccWires wires = MccWires::two_wire_two_sensors;
  float r0_ohm = 100, a_per_k = 3.9083e-3f, b_per_k2 = -5.775e-7f, c_per_k4 = -4.183e-12f;
};
/// Thermistor, by the Steinhart–Hart equation: 1/T = a + b ln R + c (ln R)³, T in K, R in Ω.
struct MccThermistor {
  MccWires wires = MccWires::two_wire_two_sensors;
  float a{}, b{}, c{};
};
/// Semiconductor sensor, whose voltage is linear in the temperature.
struct MccSemiconductor {
  bool differential{};
  float offset{}, scale{};
};
struct MccThermocouple {
  MccThermocoupleType type{};
};
using MccSensor = std::variant<MccRtd, MccThermistor, MccSemiconductor, MccThermocouple>;

/// Returns the requests that assign `sensor` to `input`. The two inputs of a converter (0 and 1, 2 and 3, …) share the
/// kind of sensor and its wiring. After the requests for all inputs, the caller
/// must send MccCommand::calibrate.
[[nodiscard]] std::vector<MccRequest> mcc_setup(std::uint8_t input, const MccSensor& sensor);

/// Returns the range of a sensor: the range of its reference table in IEC 60751 or IEC 60584-1; for other sensors,
/// absolute zero to 200 °C, which is above the temperature of every chamber.
[[nodiscard]] TemperatureRange mcc_range(const MccSensor& sensor);

inline constexpr std::array<HidKind, 2> kMccKinds{{{0x09DB, 0x008D, "USB-TEMP"}, {0x09DB, 0x0090, "USB-TC"}}};

struct MccOptions {
  /// Sensor at each input. If empty, the settings of the input are not changed or compared, and any temperature in
  /// kMccMaxRange is accepted.
  std::array<std::optional<MccSensor>, kMccInputs> sensors{};
  /// Time limit for a reply, and required silence after a missing reply.
  Duration within = std::chrono::milliseconds(500);
  /// Clock of the device; null means the steady clock.
  const Clock* clock = nullptr;
};

/// Returns the driver. After the device was opened, before the first reading, it compares the instrument's settings
/// with `sensors`. If they differ, it sets them and the instrument calibrates itself for some seconds; meanwhile read()
/// returns a timeout for every input, and identify() waits. Afterwards the settings are compared again; if they still
/// differ, the fault is a mismatch. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_mcc_usb_temp(std::unique_ptr<HidReports> reports, std::string place,
                                                             MccOptions options = {});

}  // namespace gyrotherm::drivers
