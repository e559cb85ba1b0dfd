// SPDX-License-Identifier: Apache-2.0
/// Start of a program: opening the standard descriptors, checking the command line, and writing to stdout and stderr
/// without failing when the reader has closed the pipe.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

/// Opens each of stdin, stdout and stderr that is closed. Otherwise the program's first files or sockets would get
/// their numbers. Reading a stdin opened here returns end of file, writing to such a stdout fails, and such a stderr
/// discards its text. Every main() calls this first.
void open_standard_descriptors();

/// Writes to stderr. The text is lost if it cannot be written, for example on a full disk.
void write_to_stderr(std::string_view text);
/// Writes to stdout and flushes it. Fails with storage if the text cannot be written. Succeeds if the reader has closed
/// the pipe.
[[nodiscard]] Result<void> write_to_stdout(std::string_view text);
/// Returns whether the reader of stdout has closed its end of the pipe, as `head` does.
[[nodiscard]] bool is_stdout_closed();

/// Returns the reason for refusing the value of an option or of a positional argument, or an empty string. A value must
/// not be empty. If `kind` is a number type of CLI11, the whole value must be a number without blank, "0x" or plus
/// sign: "INT" a whole number and "UINT" a whole number of at least 0, both in 64 bits; "FLOAT" a finite decimal
/// number.
[[nodiscard]] std::string value_refusal_reason(std::string_view value, std::string_view kind);

/// Returns the reason for refusing `word` as the name of a command, or an empty string if it is an option or one of the
/// commands `known`.
[[nodiscard]] std::string command_refusal_reason(std::string_view word, std::span<const std::string> known);

/// Returns the reason for refusing `word` as the first argument of a command that has both arguments and subcommands,
/// if it is a misspelt subcommand of `known`. Returns an empty string if a file or folder has this name.
[[nodiscard]] std::string misspelt_command_reason(std::string_view word, const std::string& command,
                                                  std::span<const std::string> known);

/// Returns the reason for refusing an argument that a command does not take. `form` is the command as it is typed with
/// all that it requires, such as "gyrotherm compensate MODEL".
[[nodiscard]] std::string extra_word_refusal_reason(std::string_view word, const std::string& form);

/// Returns the reason for refusing the option `word`, which `command` does not have. Suggests the nearest option of
/// `known`.
[[nodiscard]] std::string option_refusal_reason(std::string_view word, const std::string& command,
                                                std::span<const std::string> known);

/// Returns the reason for refusing an option of `command` that was given before the command.
[[nodiscard]] std::string misplaced_option_reason(std::string_view word, const std::string& command);

/// Returns CLI11's error message unchanged, except that this program's own messages replace those for an invalid
/// number, a number outside its range, a value that is not one of a list, and an option that is given several times.
[[nodiscard]] std::string plain_error_message(const std::string& refusal);

/// Returns a command as it is typed with all that it requires, such as "gyrotherm compensate MODEL".
template <class App>
std::string describe_form(const App& command) {
  std::string form = command.get_name();
  for (const auto* parent = command.get_parent(); parent != nullptr; parent = parent->get_parent())
    form.insert(0, parent->get_name() + " ");
  for (const bool is_positional : {true, false})
    for (const auto* option : command.get_options()) {
      if (option->get_positional() != is_positional || !(is_positional || option->get_required())) continue;
      const std::string type = option->get_type_name();
      const auto value = type.substr(0, type.find(':'));
      form += is_positional ? " " + value : " " + option->get_name() + " " + value;
    }
  return form;
}

/// Returns the message for a CLI11 error. It names the first unknown command or option if there is one; CLI11 may
/// report only a consequence of that. Otherwise the message is CLI11's own, `refusal`, as plain_error_message() returns
/// it.
template <class App>
std::string find_error_cause(const std::string& refusal, const App& program, std::span<char* const> words) {
  std::string cause;
  const auto check_next = [&](const App& command, std::size_t next) {
    std::vector<std::string> known;
    for (const auto* below : command.get_subcommands([](const App* each) { return !each->get_group().empty(); }))
      known.push_back(below->get_name());
    const bool has_positionals =
        !command.get_options([](const auto* option) { return option->get_positional(); }).empty();
    if (!cause.empty() || next >= words.size() || known.empty()) return;
    cause = has_positionals ? misspelt_command_reason(words[next], command.get_name(), known)
                            : command_refusal_reason(words[next], known);
  };
  const auto* command = &program;  // innermost command named so far
  check_next(program, 1);
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto named = command->get_subcommands([&](const App* each) { return each->get_name() == words[i]; });
    if (named.empty()) continue;
    command = named.front();
    check_next(*command, i + 1);
  }
  std::vector<std::string> options;
  for (const auto* option : command->get_options())
    for (const auto& name : option->get_lnames()) options.push_back("--" + name);
  for (std::size_t i = 1; i < words.size() && std::string_view(words[i]) != "--" && cause.empty(); ++i) {
    const std::string word = std::string(words[i]).substr(0, std::string_view(words[i]).find('='));
    bool is_known = !word.starts_with("--");
    for (const auto* scope = command; scope != nullptr; scope = scope->get_parent())
      is_known = is_known || scope->get_option_no_throw(word) != nullptr;
    const bool has_one_dash = word.size() > 2 && word[0] == '-' && word[1] != '-';
    if (!is_known || (has_one_dash && command->get_option_no_throw("-" + word) != nullptr))
      cause = option_refusal_reason(word, command->get_name(), options);
  }
  const auto extra = program.remaining(true);
  if (cause.empty() && !extra.empty() && command->get_option_no_throw(extra.front()) != nullptr)
    cause = misplaced_option_reason(extra.front(), command->get_name());
  if (cause.empty() && !extra.empty())
    cause = extra.front().starts_with('-') ? option_refusal_reason(extra.front(), command->get_name(), options)
                                           : extra_word_refusal_reason(extra.front(), describe_form(*command));
  if (!cause.empty()) return cause;
  constexpr std::string_view kRequired = " is required";
  if (!refusal.ends_with(kRequired)) return plain_error_message(refusal);
  const auto missing = refusal.substr(0, refusal.size() - kRequired.size());
  if (missing == "A subcommand") {
    std::string names;
    for (const auto* below : command->get_subcommands([](const App* each) { return !each->get_group().empty(); }))
      names += (names.empty() ? "" : ", ") + below->get_name();
    return command->get_name() + ": a command is required, one of " + names;
  }
  const auto* option = command->get_option_no_throw(missing);
  return option == nullptr ? refusal : refusal + ": " + option->get_description();
}

/// Makes every option of the program and its commands refuse the values that value_refusal_reason() refuses. CLI11
/// itself accepts "" as 0, "0x10" as 16, and a number above the maximum as the maximum. Call this once, after all
/// options have been added. Also makes the positionals of a command refuse a misspelt name of a command below it.
template <class App>
void refuse_invalid_values(App& app) {
  std::vector<std::string> below;
  for (const auto* command : app.get_subcommands([](const App* each) { return !each->get_group().empty(); }))
    below.push_back(command->get_name());
  for (auto* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    const std::string type = option->get_type_name();
    option->check([kind = type.substr(0, type.find(':'))](const std::string& value) {
      return value_refusal_reason(value, kind);
    });
    if (option->get_positional() && !below.empty())
      option->check([below, name = app.get_name()](const std::string& value) {
        return misspelt_command_reason(value, name, below);
      });
  }
  for (auto* command : app.get_subcommands([](const App*) { return true; })) refuse_invalid_values(*command);
}

}  // namespace gyrotherm
