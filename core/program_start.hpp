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
