// SPDX-License-Identifier: Apache-2.0
/// DCON thermocouple modules (ADAM-4018/4018+, ICP DAS I-7018, ADLINK 6018), each with eight inputs: the encoding for
/// the host and for the module (I-7018 user's manual rev. B1.0, chapters 1.10 and 2; ADAM-4000 manuals), and the
/// driver.
///
/// A line ends with CR, which is not part of the texts here. `address` is the address of a module, 0 to 255. A module
/// does not answer commands with a syntax error or with another address.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "drivers/thermometer/placed_readings.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kDconInputs = 8;

/// Setting of a module: whether lines end with the sum of their characters modulo 256, as two upper-case hexadecimal
/// digits.
enum class DconChecksum { off, on };

/// Returns `text` as it is sent, with its checksum if there is one.
[[nodiscard]] std::string seal_dcon(const std::string& text, DconChecksum checksum);
/// Returns `line` without its checksum. Fails with corrupted if the checksum is wrong.
[[nodiscard]] Result<std::string_view> unseal_dcon(std::string_view line, DconChecksum checksum);

/// Returns "#AA", the query for the readings of all inputs.
[[nodiscard]] std::string dcon_read_all(std::uint8_t address);
/// Returns "$AA" followed by `what`: "2" for the configuration, "8Ci" for the type of input i (modules with a type per
/// input), "M" for the name, "F" for the firmware, "3" for the cold junction, "6" for the enabled inputs, "B" for the
/// open inputs (not on I-7018).
[[nodiscard]] std::string dcon_query(std::uint8_t address, std::string_view what);

/// Returns the text after the address in "!AA…", a line without its checksum. Fails with refused if the line is "?AA"
/// (unknown command), and with corrupted if it is not an answer of this module.
[[nodiscard]] Result<std::string_view> decode_dcon_answer(std::string_view line, std::uint8_t address);

/// The configuration "TTCCFF" in the answer to "$AA2".
struct DconConfiguration {
  /// Type of the inputs; 10 (hexadecimal) is thermocouple T.
  std::uint8_t type{};
  std::uint8_t baud{};  ///< 06 is 9600
  /// Format of the readings, including the checksum setting.
  std::uint8_t format{};
  bool operator==(const DconConfiguration&) const = default;

  [[nodiscard]] bool in_engineering_units() const { return (format & 0x03) == 0; }
  [[nodiscard]] DconChecksum checksum() const { return (format & 0x40) != 0 ? DconChecksum::on : DconChecksum::off; }
};
/// Decodes a configuration. Fails with corrupted if `text` is not six upper-case hexadecimal digits.
[[nodiscard]] Result<DconConfiguration> decode_dcon_configuration(std::string_view text);
[[nodiscard]] std::string encode_dcon_configuration(const DconConfiguration& configuration);

/// Decodes the type of an input from "CiRTT" in the answer to "$AA8Ci". Fails with corrupted.
[[nodiscard]] Result<std::uint8_t> decode_dcon_type(std::string_view text, int input);

/// Returns the range of an input type: thermocouple J, K, T or E (0E, 0F, 10, 11). Returns nothing for other types.
/// Only T extends below 0 °C.
[[nodiscard]] std::optional<TemperatureRange> dcon_range(std::uint8_t type);

/// Decodes ">+05.123+04.153…", a line in engineering units without its checksum, to one reading per range. A value
/// consists of a sign, digits and a point, at most eight characters. All values of a line must have equal length;
/// otherwise an unexpected checksum could be decoded as decimals. "+9999" (over range), "-0000" (under range) and
/// values outside their range become out_of_range faults of their inputs, "input 0" to "input 7". Fails with refused
/// ("?AA") or corrupted.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_dcon_readings(std::string_view line, std::uint8_t address,
                                                                        std::span<const TemperatureRange> ranges);

/// Module: encodes readings with seven characters per value, `decimals` of them after the point. Values outside `range`
/// are encoded as over range or under range.
[[nodiscard]] std::string encode_dcon_readings(std::span<const double> celsius, const TemperatureRange& range,
                                               int decimals);

struct DconOptions {
  std::uint8_t address = 1;
  /// Checksum setting of the module.
  DconChecksum checksum = DconChecksum::off;
  /// Required type of all inputs; any type if empty.
  std::optional<std::uint8_t> type{};
  /// Time limit for a complete answer.
  Duration within = std::chrono::milliseconds(500);
  /// Required silence before a question.
  Duration pause = std::chrono::milliseconds(10);
  /// Clock of the line; null means the steady clock.
  const Clock* clock = nullptr;
};

/// Returns the driver of the only module on a line. It reads the module's settings before the first reading and after
/// each missing answer. Fails with mismatch if the readings are not in engineering units, or if an input is not of
/// `type`, or without `type` not a thermocouple J, K, T or E. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_dcon_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                                 DconOptions options = {});

/// Returns one thermometer for all modules at these addresses of one line. Its inputs are the inputs of all modules, in
/// the order of the modules. The modules are queried one after the other. A module that does not answer twice in a row
/// is skipped for 0.5 s, then for longer periods up to 10 s; meanwhile its inputs have faults. Each attempt to query
/// such a module delays the readings of the others by up to twice `within`.
[[nodiscard]] std::unique_ptr<Thermometer> make_dcon_modules(std::unique_ptr<ByteStream> line, const std::string& place,
                                                             const std::vector<std::uint8_t>& addresses,
                                                             const DconOptions& options = {});

}  // namespace gyrotherm::drivers
