// SPDX-License-Identifier: Apache-2.0
/// The lines in the file of a text instrument, whatever its kind: for programs that list or try them without a driver.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/text_template.hpp"

namespace gyrotherm::drivers {

/// A line of [sequence] prepare.
struct PreparingLine {
  std::string line;
  /// The answer is one of these; empty for a command without an answer.
  std::vector<TextTemplate> answers;
};

struct TextUnitFile {
  /// Links, identity, questions and commands. The items of a chamber are those of its map; the items of another
  /// instrument have the numbers on the line.
  RegisterMap unit;
  std::vector<PreparingLine> preparation;
  /// Confidence of the description, as a line of text.
  std::string confidence;
};

/// Parses a file with schema gyrotherm-text/1. A kind with its own reader is checked by that reader. Of another kind,
/// only the keys of the lines are read. Fails with bad_file and lists every error with its position; fails with usage
/// if the file has another schema. `parameters` replace those of the file; fails with usage for an unknown one.
[[nodiscard]] Result<TextUnitFile> read_text_unit_file(std::string_view text, const std::string& file,
                                                       const TextParameters& parameters = {});

}  // namespace gyrotherm::drivers
