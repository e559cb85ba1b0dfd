// SPDX-License-Identifier: Apache-2.0
/// A thermometer that a third-party program reads: the messages on the program's standard input and output, encoded for
/// host and program, and the driver. docs/adding-an-instrument.md describes the protocol.
///
/// A request is a line with a number and a keyword: "1 hello", "2 read". Its answer is one line that begins with the
/// same number. Lines end with LF, which is not part of the texts here; a CR before it is ignored.
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

/// Name and version of the protocol. Another version has another name.
inline constexpr std::string_view kProcessProtocol = "gyrotherm-thermometer/1";
inline constexpr std::size_t kMostProcessInputs = 64;
inline constexpr std::size_t kLongestProcessLine = 1024;  ///< bytes

/// Identity and number of inputs of the instrument that the program reads.
struct ProcessGreeting {
  std::size_t inputs{};  ///< 1 to kMostProcessInputs
  std::string identity;  ///< such as "Acme T-2 0815"
  bool operator==(const ProcessGreeting&) const = default;
};

/// A line such as "7 23.5 -", split into 7 and "23.5 -".
struct NumberedLine {
  std::uint64_t number{};
  std::string_view rest;
};
/// Splits a line. Returns nothing if the line does not begin with a number.
[[nodiscard]] std::optional<NumberedLine> split_numbered_line(std::string_view line);

/// Decodes "gyrotherm-thermometer/1 2 Acme T-2 0815", a line without its number. Fails with mismatch for another
/// protocol or version, and with corrupted if the text is not a greeting.
[[nodiscard]] Result<ProcessGreeting> decode_process_greeting(std::string_view text);
[[nodiscard]] std::string encode_process_greeting(const ProcessGreeting& greeting);

/// Decodes "23.456 -": one token per input, which is a decimal number in °C with an optional exponent, or "-" if the
/// input has no reading. An input without a reading, or with a value below absolute zero or above 3000 °C, is
/// out_of_range. Inputs are named "input 1" and so on. Fails with corrupted for any other token, or if the number of
/// tokens is not `inputs`.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_process_readings(std::string_view text, std::size_t inputs);
[[nodiscard]] std::string encode_process_readings(std::span<const std::optional<double>> celsius);

struct ProcessThermometerOptions {
  /// Number of inputs to read, starting with the first one.
  std::size_t channels{};
  /// Time limit for read(), including a greeting.
  Duration within = std::chrono::milliseconds(500);
  /// Time limit for identify(). It is longer because interpreters start slowly.
  Duration greeting_timeout = std::chrono::milliseconds(5000);
  /// Clock of the line; null means the steady clock.
  const Clock* clock = nullptr;
  /// Ends the program; the next request starts it again. Called after ten consecutive readings without a valid answer.
  std::function<void()> end_program{};
};

/// Returns the driver. It sends "hello" before the first reading, and again after the line broke. A late answer is
/// recognised by its number and discarded. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_process_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                                    ProcessThermometerOptions options);

}  // namespace gyrotherm::drivers
