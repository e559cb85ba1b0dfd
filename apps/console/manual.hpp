// SPDX-License-Identifier: Apache-2.0
/// Manual pages: names, synopsis and options of the description that the parser has, prose written by hand.
#pragma once

#include <string>

#include "apps/console/command_info.hpp"

namespace gyrotherm::app {

/// What a page says beside what the parser knows.
struct ManualText {
  std::string prose;    ///< as docs/man has it: paragraphs of the description, then sections
  std::string date;     ///< of the release, "2026-11-21"
  std::string version;  ///< of the program
};

/// The page of a command, with all commands below it; of the program itself a list of its commands, each with its page.
/// The sections of the prose stand between the options and the exit status, SEE ALSO at the end.
[[nodiscard]] std::string manual_page(const CommandInfo& command, const ManualText& text);
/// A page that is prose alone, of a program with a parser of its own.
[[nodiscard]] std::string manual_page(const std::string& name, const ManualText& text);

}  // namespace gyrotherm::app
