// SPDX-License-Identifier: Apache-2.0
/// The description of a laboratory power supply with a text protocol, a TOML file under profiles/supplies, used by the
/// driver and by the virtual supply. docs/supplies.md describes the format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/text_instrument.hpp"
#include "drivers/line/text_template.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kMostSupplyOutputs = 8;

/// Names of the items of an output. An item whose name ends in "trip" reports whether the output has tripped;
/// `clear_trip` is a command.
inline constexpr const char *kSetVoltage = "voltage", *kSetCurrent = "current", *kOverVoltage = "over_voltage",
                            *kOverCurrent = "over_current", *kOutputState = "output",
                            *kMeasuredVoltage = "measured_voltage", *kMeasuredCurrent = "measured_current",
                            *kClearTrip = "clear_trip";
/// Codes of the items `output`, `over_current` and of a trip.
inline constexpr const char *kOnCode = "on", *kOffCode = "off", *kTrippedCode = "tripped", *kClearCode = "clear";

struct SupplyQuestion {
  std::string ask;
  std::vector<TextTemplate> answers;
  /// The question is asked twice, and the second answer is used, because the instrument answers with a delay of one.
  bool is_asked_twice = false;
};

struct SupplyCommand {
  /// Field "value" is the written value.
  TextTemplate tell;
  /// The acknowledgement is one of these; empty if the instrument sends none.
  std::vector<TextTemplate> acknowledged;
  /// Lines without an answer that make the written value effective.
  std::vector<std::string> then;
};

struct SupplyItem {
  /// Index of the question, and the field of its answers; absent: the item cannot be read.
  std::optional<std::size_t> question;
  std::string field;
  std::optional<SupplyCommand> command;
  /// Largest difference between a written value and the value that is read back, V or A.
  double tolerance = 0.01;
  /// Texts of each code. The first one is written.
  std::map<std::string, std::vector<std::string>> codes;
  /// Bits of a trip, keyed by their meaning.
  std::map<std::string, std::uint8_t> flags;
};

/// One output, with its number inserted in all lines.
struct SupplyOutput {
  std::vector<SupplyQuestion> questions;
  std::map<std::string, SupplyItem> items;

  [[nodiscard]] const SupplyItem* find(const std::string& name) const;
};

/// Behaviour of the virtual supply, from [simulated].
struct SimulatedSupply {
  std::string identity;
  /// Answer to an unknown line; none if empty.
  std::string unknown;
};

/// The parameter of the lines of a supply that is the number of the output, from 1.
inline constexpr const char* kOutputParameter = "output";

struct SupplyDescription : TextInstrumentDescription {
  std::vector<SupplyOutput> outputs;
  /// The output trips at its current limit and has no level of its own for over-current.
  [[nodiscard]] bool trips_at_current_limit() const;
  /// Number of items of each confidence, from the most certain to the least certain.
  std::map<Confidence, int> confidences;
  std::vector<std::string> notes;
  SimulatedSupply simulated;
};

/// Parses schema gyrotherm-text/1 with kind "supply". `parameters` replace those of the file. Fails with bad_file and
/// lists every error with its position.
[[nodiscard]] Result<SupplyDescription> parse_supply_description(std::string_view text, const std::string& file,
                                                                 const TextParameters& parameters = {});

/// Returns a line of text: "3 outputs: 4 items secondary, 7 unverified; NOTE".
[[nodiscard]] std::string describe_confidence(const SupplyDescription& description);

/// Settings of one output for the unit under test.
struct OutputSettings {
  /// Index of the output.
  std::size_t output{};
  double voltage_v{};
  /// Limit of the current, A.
  double current_a{};
  /// Levels at which the output trips; absent: not set.
  std::optional<double> over_voltage_v{}, over_current_a{};
};

/// Returns the reason why the supply cannot have these settings, or an empty string.
[[nodiscard]] std::string settings_refusal_reason(const SupplyDescription& description, const OutputSettings& settings);

}  // namespace gyrotherm::drivers
