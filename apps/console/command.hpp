// SPDX-License-Identifier: Apache-2.0
/// Registers subcommands with their options and actions, and runs the selected one. An action returns an exit code or
/// a fault.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/console.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Names of the values of options and positional arguments, for ->type_name(). Help and manual pages print the name,
/// and shell completion selects files by it (command_info.hpp).
namespace value {
inline constexpr const char *kProfile = "PROFILE", *kRig = "RIG", *kMap = "MAP", *kGyro = "GYRO", *kRecord = "RECORD",
                            *kRecordOrFolder = "RECORD|FOLDER", *kModel = "MODEL", *kTable = "TABLE", *kToml = "TOML",
                            *kPem = "PEM", *kCode = "SOURCE", *kFile = "FILE", *kFolder = "FOLDER";
}  // namespace value

/// Exit codes of all programs. They must not change, because scripts rely on them.
enum class Exit : int {
  done = 0,
  outside_limits = 1,
  usage = 2,
  instrument = 3,
  file = 4,
  interrupted = 5,
  interlock = 6,
};

/// Returns the exit code for a fault that ends a command.
[[nodiscard]] Exit exit_code_for(const Fault& fault);

/// Meaning of each exit code, for manual pages.
inline constexpr std::pair<Exit, const char*> kExitMeanings[] = {
    {Exit::done, "done"},
    {Exit::outside_limits, "done, and a result is outside a limit of the profile's [accept] table"},
    {Exit::usage,
     "the command line is wrong or does not fit the files: the output exists, the run has finished, or no program is "
     "running it"},
    {Exit::instrument, "an instrument or a connection failed, or a run refused a request"},
    {Exit::file, "a file is invalid or could not be written; for run also: the record exists"},
    {Exit::interrupted, "interrupted; gyrotherm resume continues the run"},
    {Exit::interlock, "an interlock ended the run; the message states whether the chamber was made safe"}};

/// A command-line program with subcommands, and the outcome of the subcommand that was run.
struct Program {
  Program(const std::string& name, const std::string& description);

  CLI::App cli;
  Console console;
  Result<Exit> outcome = Exit::done;
};

/// Adds a subcommand to the program or to another command, as in "gyrotherm report sign". Its help begins with the
/// example. The caller sets a callback that stores the outcome in the program. Variables that receive option values
/// must outlive the program.
CLI::App& add_subcommand(Program& program, CLI::App& parent, const std::string& name, const std::string& description,
                         const std::string& example);
/// Adds a subcommand that calls `action` with its options, unless the command line contains a subcommand of it. The
/// caller may set defaults in the returned options.
template <class Options>
std::pair<CLI::App&, Options&> add_subcommand(Program& program, CLI::App& parent, const std::string& name,
                                              const std::string& description, const std::string& example,
                                              Result<Exit> (*action)(Console&, const Options&)) {
  const auto options = std::make_shared<Options>();
  auto& command = add_subcommand(program, parent, name, description, example);
  command.callback([&program, &command, options, action] {
    if (command.get_subcommands().empty()) program.outcome = action(program.console, *options);
  });
  return {command, *options};
}

/// Adds a command to the program itself.
CLI::App& add_command(Program& program, const std::string& name, const std::string& description,
                      const std::string& example);

template <class Options>
std::pair<CLI::App&, Options&> add_command(Program& program, const std::string& name, const std::string& description,
                                           const std::string& example,
                                           Result<Exit> (*action)(Console&, const Options&)) {
  return add_subcommand(program, program.cli, name, description, example, action);
}

/// Adds `completion SHELL`, which prints a script that completes this program's command lines.
void add_completion(Program& program);
/// Adds the hidden subcommand `manual [COMMAND]`, with which the build generates the manual pages.
void add_manual(Program& program);

/// Adds the option --outside, which selects the treatment of inputs outside the trained range. `refused` describes, in
/// the help, what happens to a refused input.
void add_outside_option(CLI::App& command, std::string& outside, const std::string& refused = "not compensated");

/// Refuses a value that begins with a minus sign: a negative number or a mistyped option.
[[nodiscard]] CLI::Validator not_negative();
/// Refuses "-" as the name of an output that cannot be standard output.
[[nodiscard]] CLI::Validator reject_dash();

/// Adds a subcommand that does not parse its arguments, not even --help, and passes all of them to `action`.
void add_forwarding_subcommand(Program& program, const std::string& name, const std::string& description,
                               const std::string& example,
                               std::function<Result<Exit>(const std::vector<std::string>& arguments)> action);

/// Replaces this process by another program in the same folder. Returns only if that fails.
[[nodiscard]] Result<Exit> exec_sibling_program(const std::string& name, std::vector<std::string> arguments);

/// Parses the command line, runs the subcommand and prints its fault, if any. Returns the exit code.
[[nodiscard]] int run(Program& program, int argc, char** argv);

/// Returns the peak resident memory of the process, MB.
[[nodiscard]] double peak_memory_mb();

}  // namespace gyrotherm::app
