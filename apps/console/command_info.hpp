// SPDX-License-Identifier: Apache-2.0
/// The commands of a program and their options as the parser of the command line knows them: the one description that
/// manual pages and the shells' completions are made of.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/shipped.hpp"

namespace gyrotherm::app {

/// An option, or a word that stands by itself.
struct OptionInfo {
  std::vector<std::string> names;    ///< "--verbose", "-v"; empty for a word
  std::string value;                 ///< what it takes, like "RIG" (value.hpp); empty for a flag
  std::vector<std::string> choices;  ///< where it is one of a few words
  std::string description;
  bool is_required = false;
  bool repeats = false;  ///< may have several values
};

struct CommandInfo {
  std::vector<std::string> path;  ///< "report", "sign"; empty for the program itself
  std::string program;
  std::string example;
  std::string description;
  std::vector<OptionInfo> options{};  ///< in the order of the help
  std::vector<OptionInfo> words{};
  std::vector<CommandInfo> below{};
};

/// A kind of value, with which files a shell completes it.
struct ValueKind {
  std::string_view name;
  const ShippedKind* shipped;             ///< names of shipped files, or null
  std::vector<std::string_view> endings;  ///< of files, like "db"; empty: every file
  bool is_folder = false;                 ///< folders alone
};

/// The kind of that name, or null if its values are no files.
[[nodiscard]] const ValueKind* value_kind(std::string_view name);

/// Hidden commands and options are left out.
[[nodiscard]] CommandInfo describe_commands(const CLI::App& program);

/// The first sentence of a description, its first letter small and without its full stop, as a list shows it.
[[nodiscard]] std::string in_short(const std::string& description);

}  // namespace gyrotherm::app
