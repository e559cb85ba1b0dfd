// SPDX-License-Identifier: Apache-2.0
/// How a program begins: its standard descriptors are open, and each value on its command line is one that its option
/// can mean. And how it speaks, where it has no console of its own: what nobody takes ends no program.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

/// Opens what the caller has left closed of stdin, stdout and stderr, so that no file and no socket of the program gets
/// such a number: stdin is at its end, what is written to stdout fails and is missed, and stderr goes nowhere. The
/// first call of each main().
void open_standard_descriptors();

/// Says it to whoever reads stderr; where nobody does, as on a full disk, it is lost.
void write_to_stderr(std::string_view text);
/// Hands data to whoever reads stdout, at once. Fails with storage if they cannot be written; a reader who has had
/// enough is no fault.
[[nodiscard]] Result<void> write_to_stdout(std::string_view text);
/// Whether whoever read stdout has had enough of it, as `head` has.
[[nodiscard]] bool reader_has_left();

/// What is wrong with the value of an option, or of a word after a command; empty: nothing. It must not be empty, and
/// where `kind` is "INT", "UINT" or "FLOAT", as CLI11 calls its numbers, it is all a decimal number of 64 bits: no
/// blank, no "0x", no plus sign, no NaN, no infinity.
[[nodiscard]] std::string objection_to(std::string_view value, std::string_view kind);

/// What is wrong with a first word, of a program with these commands; empty: nothing, or it is an option.
[[nodiscard]] std::string objection_to_command(std::string_view word, std::span<const std::string> known);

/// What is wrong with an option that is none, of a command of that name with these.
[[nodiscard]] std::string objection_to_option(std::string_view word, const std::string& command,
                                              std::span<const std::string> known);

/// What CLI11 says, its own words for a number that is none made ours.
[[nodiscard]] std::string in_our_words(const std::string& refusal);

/// The cause of a command line that CLI11 refuses with these words, before what follows from it: the first word that is
/// no command, or no option.
template <class App>
std::string cause_of(const std::string& refusal, const App& program, std::span<char* const> words) {
  std::string objection;
  const auto look_behind = [&](const App& command, std::size_t next) {
    std::vector<std::string> known;
    for (const auto* below : command.get_subcommands([](const App* each) { return !each->get_group().empty(); }))
      known.push_back(below->get_name());
    const bool takes_words = !command.get_options([](const auto* option) { return option->get_positional(); }).empty();
    if (objection.empty() && next < words.size() && !known.empty() && !takes_words)
      objection = objection_to_command(words[next], known);
  };
  const auto* command = &program;  // the innermost that is named
  look_behind(program, 1);
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto named = command->get_subcommands([&](const App* each) { return each->get_name() == words[i]; });
    if (named.empty()) continue;
    command = named.front();
    look_behind(*command, i + 1);
  }
  std::vector<std::string> options;
  for (const auto* option : command->get_options())
    for (const auto& name : option->get_lnames()) options.push_back("--" + name);
  for (std::size_t i = 1; i < words.size() && std::string_view(words[i]) != "--" && objection.empty(); ++i) {
    const std::string word = std::string(words[i]).substr(0, std::string_view(words[i]).find('='));
    bool is_known = !word.starts_with("--");
    for (const auto* of = command; of != nullptr; of = of->get_parent())
      is_known = is_known || of->get_option_no_throw(word) != nullptr;
    if (!is_known) objection = objection_to_option(word, command->get_name(), options);
  }
  return objection.empty() ? in_our_words(refusal) : objection;
}

/// Has every option of the program and of its commands refuse what objection_to() objects to. CLI11 by itself takes ""
/// for 0, "0x10" for 16, and a number that is too large for the largest. Called once, when all options are there.
template <class App>
void refuse_wrong_values(App& app) {
  for (auto* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    const std::string type = option->get_type_name();
    option->check(
        [kind = type.substr(0, type.find(':'))](const std::string& value) { return objection_to(value, kind); });
  }
  for (auto* command : app.get_subcommands([](const App*) { return true; })) refuse_wrong_values(*command);
}

}  // namespace gyrotherm
