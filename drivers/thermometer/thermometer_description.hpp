// SPDX-License-Identifier: Apache-2.0
/// The description of a thermometer scanner with a text protocol, a TOML file under profiles/thermometers, used by the
/// driver and by the virtual scanner. docs/text-instruments.md describes the format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/chamber/text_instrument.hpp"
#include "drivers/line/text_template.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kMostTextInputs = 64;
/// Fields of the answers with readings.
inline constexpr const char *kReadingField = kTextValueField, *kReadingStatusField = "status";

/// A question about one or more consecutive inputs.
struct InputQuestion {
  /// Commands without an answer that precede the question.
  std::vector<std::string> before;
  std::string ask;
  /// Field "value" is the number of the input, or a list if there are several. In a question for readings, field
  /// "status" may be its status.
  std::vector<TextTemplate> answers;
  std::size_t first{}, count = 1;
};

enum class TemperatureUnit { celsius, kelvin, fahrenheit };

/// Behaviour of the virtual instrument, from [simulated].
struct SimulatedScanner {
  std::string identity;
  /// Format of a number after "%", such as "+.8E"; empty: the form of the template.
  std::string number;
  /// Text of the reading of an input without a thermometer, and its status.
  std::string invalid;
  std::int64_t invalid_status{};
  /// Answer to an unknown line; none if empty.
  std::string unknown;
};

struct ThermometerDescription : TextInstrumentDescription {
  std::vector<InputQuestion> readings;
  /// As many as readings, or none.
  std::vector<InputQuestion> statuses;
  /// Number of inputs, at least 1.
  std::size_t inputs{};
  /// Time limit for the answer to one question for readings; the timeout of the link if empty.
  std::optional<Duration> within{};
  TemperatureUnit temperature_unit{};
  /// A number whose magnitude exceeds this marks an input that cannot be read.
  std::optional<double> invalid_above;
  TemperatureRange range{};
  /// Bits of a status that make the reading invalid, keyed by their meaning.
  std::map<std::string, std::uint8_t> flags;
  Confidence confidence = Confidence::unverified;
  std::vector<std::string> notes;
  SimulatedScanner simulated;
};

/// Parses schema gyrotherm-text/1 with kind "thermometer". `parameters` replace those of the file. Fails with bad_file
/// and lists every error with its position.
[[nodiscard]] Result<ThermometerDescription> parse_thermometer_description(std::string_view text,
                                                                           const std::string& file,
                                                                           const TextParameters& parameters = {});

/// Returns the reading of an input, or its fault: `number` exceeds `invalid_above`, `status` has a flag, or the
/// temperature is outside the range. `input` counts from 0.
[[nodiscard]] Result<Celsius> convert_reading(const ThermometerDescription& description, std::size_t input,
                                              double number, std::int64_t status);

/// Returns a temperature as the number that the instrument sends.
[[nodiscard]] double to_number(const ThermometerDescription& description, Celsius reading);

/// Returns a line of text: "8 inputs: manual; NOTE".
[[nodiscard]] std::string describe_confidence(const ThermometerDescription& description);

}  // namespace gyrotherm::drivers
