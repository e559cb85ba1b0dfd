// SPDX-License-Identifier: Apache-2.0
/// Describes the commands and options of a program, as read from the command-line parser, for manual pages and shell
/// completions.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/shipped.hpp"

namespace gyrotherm::app {

/// Option or positional argument.
struct OptionInfo {
  /// Such as "-v" and "--verbose"; empty for a positional argument.
  std::vector<std::string> names;
  /// Name of the value, such as "RIG" (namespace value); empty for a flag.
  std::string value;
  /// Permitted values; empty: not a fixed list.
  std::vector<std::string> choices;
  std::string description;
  bool is_required = false;
  bool is_repeatable = false;  ///< takes several values
};

struct CommandInfo {
  /// Such as "report" and "sign"; empty for the program itself.
  std::vector<std::string> path;
  std::string program;
  std::string example;
  std::string description;
  std::vector<OptionInfo> options{};  ///< in the order of the help
  std::vector<OptionInfo> positionals{};
  std::vector<CommandInfo> subcommands{};
};

/// Kind of file that an option expects. Shell completion offers only such files.
struct ValueKind {
  std::string_view name;
  /// Kind of shipped files; null: none are shipped.
  const ShippedKind* shipped;
  /// File name extensions such as "db"; empty for all files.
  std::vector<std::string_view> extensions;
  bool is_folder = false;  ///< completion offers folders only
};

/// Returns the kind of value with this name, or null if values of this name are not files.
[[nodiscard]] const ValueKind* find_value_kind(std::string_view name);

/// Describes all commands and options except hidden ones.
[[nodiscard]] CommandInfo describe_commands(const CLI::App& program);

/// Returns the first sentence of a description, up to a colon or semicolon, without full stop and with the first letter
/// in lower case.
[[nodiscard]] std::string short_description(const std::string& description);

}  // namespace gyrotherm::app
