// SPDX-License-Identifier: Apache-2.0
/// The profile memory of a text unit: the lines that store a program and the questions that read it back. Each line
/// occupies virtual registers, so that the upload and the virtual chamber treat it as a block of a register map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/chamber/register_item.hpp"
#include "drivers/line/text_template.hpp"

namespace gyrotherm {
class TomlTable;
}

namespace gyrotherm::drivers {

struct RegisterMap;
class TemplateReader;

/// First virtual register of a profile memory.
inline constexpr std::uint16_t kTextMemoryFirst = 51200;

/// Fields of the questions, known without an answer.
inline constexpr const char *kProgramNumberField = "number", *kProgramStepField = "step",
                            *kProgramStepCountField = "step_count";

/// Place of a field's value in the registers of its line. Numbers are stored as multiples of their resolution.
struct TextMemoryCell {
  std::string field;
  std::uint16_t at{};  ///< register within the line
  RegisterItem form;
  /// Texts of the codes, by the number in the registers; empty for a number or a name.
  std::vector<std::string> codes;
};

/// A line that stores a part of a program. The values for the first step occupy `count` registers from `first` on;
/// those for each later step follow `stride` registers later.
struct TextMemoryLine {
  std::uint16_t first{}, count{}, stride{};
  int steps = 1;
  TextTemplate tell;
  std::vector<TextTemplate> acknowledged;
  /// Question that reads the line back, with the fields "number" and "step"; absent if it cannot be read.
  std::optional<TextTemplate> ask;
  std::vector<TextTemplate> answers;
  std::vector<TextMemoryCell> cells;

  /// Returns the index of the step whose registers begin at or before `address`, which must not be below `first`.
  [[nodiscard]] int step_at(std::uint16_t address) const { return stride == 0 ? 0 : (address - first) / stride; }
  /// Returns the first register of the line for a step.
  [[nodiscard]] std::uint16_t address_of(int step) const { return static_cast<std::uint16_t>(first + step * stride); }
  [[nodiscard]] bool contains(std::uint16_t address) const {
    if (address < first || step_at(address) >= steps) return false;
    return address - address_of(step_at(address)) < count;
  }
};

/// Returns the fields for the registers of a line.
[[nodiscard]] FieldValues to_fields(const TextMemoryLine& line, std::span<const std::uint16_t> words);
/// Returns the registers for the fields of a line. A field without a value is zero. Returns nothing if a text is not a
/// code.
[[nodiscard]] std::optional<std::vector<std::uint16_t>> to_words(const TextMemoryLine& line, const FieldValues& fields);
/// Returns the name and value of the first cell in which two contents of a line differ: "target is 25, expected 26".
[[nodiscard]] std::string describe_difference(const TextMemoryLine& line, std::span<const std::uint16_t> found,
                                              std::span<const std::uint16_t> expected);

/// Reads [profile_memory] of a text unit into `map.memory` and returns its lines. Errors are noted in the table.
[[nodiscard]] std::vector<TextMemoryLine> read_text_memory(const TomlTable& table, const TemplateReader& templates,
                                                           RegisterMap& map);

}  // namespace gyrotherm::drivers
