// SPDX-License-Identifier: Apache-2.0
/// A thermometer whose driver is somebody else's program, spoken to on its standard input and output: text ↔ values,
/// both ends of the line, and who asks. docs/adding-an-instrument.md describes the protocol.
///
/// A question is a line, its number and a word: "1 hello", "2 read". Its answer is one line that begins with the same
/// number. Lines end with LF, which is not part of the texts here; a CR before it is ignored.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
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
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// The protocol and its version; a program that speaks another one says another.
inline constexpr std::string_view kProcessProtocol = "gyrotherm-thermometer/1";
inline constexpr std::size_t kMostProcessInputs = 64;
inline constexpr std::size_t kLongestProcessLine = 1024;  ///< bytes

/// Who answers, and how many inputs it has.
struct ProcessGreeting {
  std::size_t inputs{};  ///< 1 to kMostProcessInputs
  std::string identity;  ///< "Acme T-2 0815"
  bool operator==(const ProcessGreeting&) const = default;
};

/// "7 23.5 -" → 7 and "23.5 -". Nothing if the line does not begin with a number.
struct NumberedLine {
  std::uint64_t number{};
  std::string_view rest;
};
[[nodiscard]] std::optional<NumberedLine> split_numbered_line(std::string_view line);

/// "gyrotherm-thermometer/1 2 Acme T-2 0815", without the line's number. Fails with mismatch if that is another
/// protocol or version, with corrupted if it is no greeting.
[[nodiscard]] Result<ProcessGreeting> decode_process_greeting(std::string_view text);
[[nodiscard]] std::string encode_process_greeting(const ProcessGreeting& greeting);

/// "23.456 -", one word an input: °C as decimals, with an exponent if need be, or "-" where there is no reading, which
/// is out_of_range in its place like what is below absolute zero or above 3000 °C. Inputs are named "input 1" and so
/// on. Fails with corrupted if a word is something else, or if there are not `inputs` words.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_process_readings(std::string_view text, std::size_t inputs);
[[nodiscard]] std::string encode_process_readings(std::span<const std::optional<double>> celsius);

struct ProcessThermometerOptions {
  std::size_t channels{};                                    ///< inputs that are read, the first ones
  Duration within = std::chrono::milliseconds(500);          ///< for a reading, the greeting included
  Duration greets_within = std::chrono::milliseconds(5000);  ///< for identify(): interpreters start slowly
  const Clock* clock = nullptr;                              ///< of a line with a time of its own
  /// Ends the program, which is started anew by the next question; called after ten questions in a row that had no
  /// good answer.
  std::function<void()> end_program{};
};

/// The program is greeted before the first reading, and again after its line broke. An answer that is late is thrown
/// away, for its number is an older one. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_process_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                                    ProcessThermometerOptions options);

}  // namespace gyrotherm::drivers
