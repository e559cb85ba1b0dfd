// SPDX-License-Identifier: Apache-2.0
/// Thermocouple modules that speak DCON (ADAM-4018/4018+, ICP DAS I-7018, ADLINK 6018), eight thermometers each: text ↔
/// values, both ends of the line (I-7018 user's manual rev. B1.0, chapters 1.10 and 2; ADAM-4000 manuals), and who
/// asks.
///
/// A line ends with CR, which is not part of the texts here. `address` is a module's, 0 to 255. The answer to a syntax
/// error or to an address without a module never comes.
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

/// Whether lines end with the sum of their characters, modulo 256, as two upper-case hexadecimal digits; a switch of
/// the module.
enum class DconChecksum { off, on };

/// `text` as it goes onto the line.
[[nodiscard]] std::string seal_dcon(std::string text, DconChecksum checksum);
/// `line` without its checksum. Fails with corrupted if that is not the line's own.
[[nodiscard]] Result<std::string_view> unseal_dcon(std::string_view line, DconChecksum checksum);

/// "#AA", asking for all inputs.
[[nodiscard]] std::string dcon_read_all(std::uint8_t address);
/// "$AA" and what to tell: "2" the configuration, "8Ci" the type of input i (modules whose inputs have a type each),
/// "M" the name, "F" the firmware, "3" the cold junction, "6" which inputs are enabled, "B" which are open (not on
/// I-7018).
[[nodiscard]] std::string dcon_ask(std::uint8_t address, std::string_view what);

/// "!AA…" (already unsealed) → what follows the address. Fails with refused ("?AA": the module does not know the
/// command) or corrupted (another module's answer, or none).
[[nodiscard]] Result<std::string_view> decode_dcon_answer(std::string_view line, std::uint8_t address);

/// "TTCCFF" of the answer to "$AA2".
struct DconConfiguration {
  std::uint8_t type{};    ///< of the inputs; 10 (hexadecimal) is thermocouple T
  std::uint8_t baud{};    ///< 06 is 9600
  std::uint8_t format{};  ///< of the readings, and the checksum's switch
  bool operator==(const DconConfiguration&) const = default;

  [[nodiscard]] bool in_engineering_units() const { return (format & 0x03) == 0; }
  [[nodiscard]] DconChecksum checksum() const { return (format & 0x40) != 0 ? DconChecksum::on : DconChecksum::off; }
};
/// Fails with corrupted if `text` is not six upper-case hexadecimal digits.
[[nodiscard]] Result<DconConfiguration> decode_dcon_configuration(std::string_view text);
[[nodiscard]] std::string encode_dcon_configuration(const DconConfiguration& configuration);

/// "CiRTT" of the answer to "$AA8Ci" → the type of input i. Fails with corrupted.
[[nodiscard]] Result<std::uint8_t> decode_dcon_type(std::string_view text, int input);

/// What a module that is set to thermocouple J, K, T or E (0E, 0F, 10, 11) can report. Only T goes below 0 °C.
[[nodiscard]] std::optional<TemperatureRange> dcon_range(std::uint8_t type);

/// ">+05.123+04.153…" (already unsealed), in engineering units → one reading per range. A value is a sign, digits and a
/// point, at most eight characters, and all values of a line are equally long, so that a checksum that nobody asked for
/// is not taken for decimals. "+9999" (over range), "-0000" (under range) and what is outside its range are faults
/// (out_of_range) in their place, named "input 0" to "input 7". Fails with refused ("?AA") or corrupted.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_dcon_readings(std::string_view line, std::uint8_t address,
                                                                        std::span<const TemperatureRange> ranges);

/// The module's side: seven characters a value, `decimals` of them after the point; outside `range` as the module says
/// it.
[[nodiscard]] std::string encode_dcon_readings(std::span<const double> celsius, const TemperatureRange& range,
                                               int decimals);

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
