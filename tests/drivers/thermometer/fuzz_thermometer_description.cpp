// SPDX-License-Identifier: Apache-2.0
/// Fuzzes descriptions of thermometer scanners: any text, edits of the shipped files, and any answers to the questions
/// of an accepted description. A reading must be within the range of the description.
#include <cstdlib>
#include <string>
#include <vector>

#include "drivers/thermometer/text_thermometer.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/fuzz_target.hpp"
#include "tests/support/shipped_texts.hpp"

namespace gyrotherm::drivers {

namespace {

const std::vector<std::string>& shipped_descriptions() {
  static const auto all = tests::read_shipped_texts(GYROTHERM_SOURCE_DIR "/profiles/thermometers");
  return all;
}

/// Reads twice an instrument that has the right identity and prepares itself, and whose readings are any text.
void use(const ThermometerDescription& description, const std::string& answer) {
  auto stream = std::make_unique<tests::FakeStream>();
  const auto& wire = description.unit.link.text;
  stream->instrument = [&](std::string_view line) -> std::string {
    const auto is = [&](const std::string& question) { return line == question + wire.question_end; };
    if (is(description.unit.text_link->identity_question))
      return description.unit.text_link->identity_answers.front().format(
                 {{kReadingField, description.simulated.identity}}) +
             wire.answer_end;
    for (const auto& step : description.preparation)
      if (is(step.line) && !step.answers.empty())
        return step.answers.front().format({{step.field, step.required}}) + wire.answer_end;
    return answer + wire.answer_end;
  };
  const auto driver = make_text_thermometer(description, std::move(stream), "fuzz");
  for (int i = 0; i < 2; ++i) {
    const auto readings = driver->read();
    if (readings.size() != description.inputs) std::abort();
    for (const auto& reading : readings)
      if (reading && !(*reading >= description.range.lowest && *reading <= description.range.highest)) std::abort();
  }
}

}  // namespace

FUZZ_TARGET(thermometer_description, const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  (void)parse_thermometer_description(text, "fuzz");
  if (size < 8) return 0;
  const auto& shipped = shipped_descriptions()[data[0] % shipped_descriptions().size()];
  if (const auto whole = parse_thermometer_description(shipped, "fuzz")) {
    use(*whole, text);
    // Repeats the test with the bytes mapped to the characters of readings.
    std::string numbers = data[1] % 2 == 0 ? "1;" : "";
    for (const char byte : text) numbers += ",,,;. -+eE0123456789,12345678900"[byte & 31];
    use(*whole, numbers);
  }
  const auto edited = tests::edit_text(shipped, data, size);
  if (const auto description = parse_thermometer_description(edited, "fuzz")) use(*description, text);
  return 0;
}

}  // namespace gyrotherm::drivers
