// SPDX-License-Identifier: Apache-2.0
/// Fuzzes descriptions of power supplies: any text, edits of the shipped files, and any answers to the questions of an
/// accepted description. A supply must not be reported as switched on unless its answers say so.
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "drivers/supply/power_supply.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/fuzz_target.hpp"
#include "tests/support/shipped_texts.hpp"

namespace gyrotherm::drivers {

namespace {

const std::vector<std::string>& shipped_supplies() {
  static const auto all = tests::read_shipped_texts(GYROTHERM_SOURCE_DIR "/profiles/supplies");
  return all;
}

/// Switches and reads a supply that has the right identity and whose other answers are any text.
void use_supply(const SupplyDescription& description, const std::string& answer) {
  auto stream = std::make_unique<tests::FakeStream>();
  const auto& wire = description.unit.link.text;
  stream->instrument = [&](std::string_view line) -> std::string {
    if (line == description.unit.text_link->identity_question + wire.question_end)
      return description.unit.text_link->identity_answers.front().format(
                 {{kTextValueField, description.simulated.identity}}) +
             wire.answer_end;
    return answer + wire.answer_end;
  };
  const auto supply =
      make_text_supply(description, {{.output = 0, .voltage_v = 24, .current_a = 1}}, std::move(stream), "fuzz");
  for (const auto demand : {PowerDemand::on, PowerDemand::off, PowerDemand::on_after_trip}) {
    supply->demand(demand);
    const auto readings = supply->read();
    if (readings.outputs.size() != 1) std::abort();
    const auto& output = readings.outputs.front();
    if (output && !(std::isfinite(output->voltage_v) && std::isfinite(output->current_a))) std::abort();
    const bool is_verified = readings.pending == PowerDemand::keep;
    if (is_verified && output && output->is_on != (demand != PowerDemand::off)) std::abort();
  }
}

}  // namespace

FUZZ_TARGET(supply_description, const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  (void)parse_supply_description(text, "fuzz");
  if (size < 8) return 0;
  const auto& shipped = shipped_supplies()[data[0] % shipped_supplies().size()];
  if (const auto whole = parse_supply_description(shipped, "fuzz")) {
    use_supply(*whole, text);
    std::string numbers;
    for (const char byte : text) numbers += "VA,ONF. -+eE0123456789,124YES101"[byte & 31];
    use_supply(*whole, numbers);
  }
  const auto edited = tests::edit_text(shipped, data, size);
  if (const auto description = parse_supply_description(edited, "fuzz")) use_supply(*description, text);
  return 0;
}

}  // namespace gyrotherm::drivers
