// SPDX-License-Identifier: Apache-2.0
/// MCC USB-TEMP and USB-TC, eight inputs over HID: reports ↔ values, both ends (formats of the vendor's public library
/// uldaq 1.2.1 and of the USB-TEMP specification), what sensors they can be told that they have, and who asks.
///
/// A request is one output report, byte 0 its command; a reply is one input report with the same byte 0. Integers are
/// little-endian, numbers IEEE-754 binary32, little-endian. Either may carry bytes beyond its contents: some systems
/// pad. Reports that write memory or firmware are not spoken.
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

/// What is set or read per input. The first four are shared by the two inputs of a converter (0 and 1, 2 and 3, …); of
/// the others, from `thermocouple` on, each input has its own. `reference_v` and the items that hold coefficients are
/// numbers, the others bytes.
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

enum class MccUnits : std::uint8_t { celsius = 0, raw = 1 };  ///< raw: V or Ω, by the type of the sensor

/// Inputs are 0 to 7; these two are the cold junctions, which no scan contains.
inline constexpr std::uint8_t kMccColdJunction0 = 0x80, kMccColdJunction1 = 0x81;

/// In place of a temperature.
inline constexpr float kMccOpen = -8888, kMccNotReady = -9000, kMccDisabled = -9999;

struct MccRequest {
  MccCommand command{};
  std::vector<std::uint8_t> arguments;
  bool operator==(const MccRequest&) const = default;
};

/// A request whose arguments are given as they stand on the wire; as many as the command takes.
[[nodiscard]] MccRequest mcc_request(MccCommand command, std::initializer_list<std::uint8_t> arguments = {});
[[nodiscard]] MccRequest mcc_read_input(std::uint8_t input, MccUnits units = MccUnits::celsius);
[[nodiscard]] MccRequest mcc_scan(std::uint8_t first, std::uint8_t last, MccUnits units = MccUnits::celsius);
/// `count` bytes, at most 62, of the user's memory, which has 256.
[[nodiscard]] MccRequest mcc_read_memory(std::uint8_t address, std::uint8_t count);
[[nodiscard]] MccRequest mcc_read_item(std::uint8_t input, MccItem item);
[[nodiscard]] MccRequest mcc_set_item(std::uint8_t input, MccItem item, std::uint8_t value);
[[nodiscard]] MccRequest mcc_set_item(std::uint8_t input, MccItem item, float value);
/// Where the date of the last calibration is.
[[nodiscard]] inline MccRequest mcc_read_calibration_date() { return mcc_read_memory(0xF0, 6); }

/// As short as it can be. hidraw refuses reports of one byte: who writes them there adds a zero.
[[nodiscard]] std::vector<std::byte> encode_mcc_request(const MccRequest& request);
/// The instrument's side; zeros may follow. Fails with corrupted (unknown command, wrong length) or refused (an
/// argument that the instrument does not have).
[[nodiscard]] Result<MccRequest> decode_mcc_request(std::span<const std::byte> report);

/// How many bytes follow byte 0 in the reply to `request`; 0: there is no reply.
[[nodiscard]] std::size_t mcc_reply_length(const MccRequest& request);
/// The reply's bytes after byte 0: memory, status, burnout, an item that is a byte. Fails with corrupted if the report
/// is another command's or too short.
[[nodiscard]] Result<std::vector<std::uint8_t>> decode_mcc_bytes(const MccRequest& request,
                                                                 std::span<const std::byte> report);
/// The reply's numbers, as they are: raw inputs, an item that is a number. Fails likewise.
[[nodiscard]] Result<std::vector<float>> decode_mcc_numbers(const MccRequest& request,
                                                            std::span<const std::byte> report);

using MccRanges = std::array<TemperatureRange, kMccInputs>;
/// From absolute zero to the end of type B, for inputs whose sensor is not known.
inline constexpr TemperatureRange kMccWidest{{-273.15}, {1820}};
[[nodiscard]] constexpr MccRanges mcc_widest_ranges() {
  MccRanges ranges{};
  ranges.fill(kMccWidest);
  return ranges;
}

/// The temperatures of a scan, or of one input, that was asked for in °C. Fails with corrupted; an input that is open,
/// not ready or disabled, or outside its range, is a fault (out_of_range) in its place.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_mcc_temperatures(
    const MccRequest& request, std::span<const std::byte> report, const MccRanges& ranges = mcc_widest_ranges());

/// Whether a calibration runs: readings are frozen and items cannot be set meanwhile.
[[nodiscard]] constexpr bool mcc_calibrating(std::uint8_t status) { return (status & 1) != 0; }

/// Six bytes of memory: year − 2000, month, day, hour, minute, second; the zone is not known. Fails with corrupted if
/// there is no such time.
[[nodiscard]] Result<std::chrono::local_seconds> decode_mcc_date(std::span<const std::uint8_t> bytes);

/// The instrument's side of a reply.
[[nodiscard]] std::vector<std::byte> encode_mcc_bytes(MccCommand command, std::span<const std::uint8_t> bytes);
[[nodiscard]] std::vector<std::byte> encode_mcc_numbers(MccCommand command, std::span<const float> numbers);

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
