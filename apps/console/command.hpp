// SPDX-License-Identifier: Apache-2.0
/// What every subcommand is made of: options, and an action that ends in an exit code or a fault; and what more than
/// one of them asks of the machine.
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

/// Names of the values that options and positionals take, for ->type_name(value::kRig). Help and manual show the name,
/// and a shell completes the value accordingly (command_info.hpp).
namespace value {
inline constexpr const char *kProfile = "PROFILE", *kRig = "RIG", *kMap = "MAP", *kGyro = "GYRO", *kRecord = "RECORD",
                            *kRecordOrFolder = "RECORD|FOLDER", *kModel = "MODEL", *kTable = "TABLE", *kToml = "TOML",
                            *kPem = "PEM", *kCode = "SOURCE", *kFile = "FILE", *kFolder = "FOLDER";
}  // namespace value

/// The exit codes that users rely on.
enum class Exit : int {
  done = 0,
  outside_limits = 1,
  usage = 2,
  instrument = 3,
  file = 4,
  interrupted = 5,
  interlock = 6,
};

[[nodiscard]] Exit exit_for(const Fault& fault);

/// What each of them means, as manual pages say it.
inline constexpr std::pair<Exit, const char*> kExitMeanings[] = {
    {Exit::done, "done"},
    {Exit::outside_limits, "done, and a result is outside a limit of the profile's [accept] table"},
    {Exit::usage,
     "the command line is wrong, or does not fit what is there: an output that exists, a run that has finished, nobody "
     "to tell"},
    {Exit::instrument, "an instrument or a connection failed, or a run refused what it was told"},
    {Exit::file, "a file is wrong, or could not be written; of run, also a record that exists"},
    {Exit::interrupted, "interrupted; gyrotherm resume goes on"},
    {Exit::interlock,
     "an interlock ended the run, and the chamber was made safe or could not be: the message says which"}};

/// A program of subcommands.
struct Program {
  Program(const std::string& name, const std::string& description);

  CLI::App cli;
  Console console;
  Result<Exit> outcome = Exit::done;
};

/// Adds a subcommand to the program, or below another command: "gyrotherm report sign". Its help opens with an example.
/// What its options are read into lives as long as the program; its callback puts the outcome into the program.
CLI::App& add_subcommand(Program& program, CLI::App& parent, const std::string& name, const std::string& description,
                         const std::string& example);
/// Does the same, and has it carry out `what` with its options, in which defaults may be put first; nothing where one
/// of its own subcommands is given.
template <class Options>
std::pair<CLI::App&, Options&> add_subcommand(Program& program, CLI::App& parent, const std::string& name,
                                              const std::string& description, const std::string& example,
                                              Result<Exit> (*what)(Console&, const Options&)) {
  const auto options = std::make_shared<Options>();
  auto& command = add_subcommand(program, parent, name, description, example);
  command.callback([&program, &command, options, what] {
    if (command.get_subcommands().empty()) program.outcome = what(program.console, *options);
  });
  return {command, *options};
}

/// Each to the program itself.
CLI::App& add_command(Program& program, const std::string& name, const std::string& description,
                      const std::string& example);

template <class Options>
std::pair<CLI::App&, Options&> add_command(Program& program, const std::string& name, const std::string& description,
                                           const std::string& example, Result<Exit> (*what)(Console&, const Options&)) {
  return add_subcommand(program, program.cli, name, description, example, what);
}

/// `completion SHELL`: a script that completes this program's command lines.
void add_completion(Program& program);
/// `manual [COMMAND]`, which the build makes the manual pages with.
void add_manual(Program& program);

/// The option --outside, what to do with inputs beyond those of the training; `refused` is what becomes of one that is
/// refused.
void add_outside_option(CLI::App& command, std::string& outside, const std::string& refused = "not compensated");

/// Refuses what begins with a minus sign.
[[nodiscard]] CLI::Validator not_negative();
/// Refuses "-" for a file or a folder that is written: it is no word for standard output there.
[[nodiscard]] CLI::Validator not_a_dash();

/// Adds a subcommand that reads none of the words after it, options and --help among them, but hands them to `action`.
void add_forwarded(Program& program, const std::string& name, const std::string& description,
                   const std::string& example,
                   std::function<Result<Exit>(const std::vector<std::string>& words)> action);

/// Becomes a program that was installed beside this one, with these words on its command line; returns only if that
/// cannot be.
[[nodiscard]] Result<Exit> become_program(const std::string& name, std::vector<std::string> words);

/// Reads the command line, carries the subcommand out, says what became of it; returns the exit code.
[[nodiscard]] int run(Program& program, int argc, char** argv);

/// The most that the program has held so far.
[[nodiscard]] double peak_memory_mb();

}  // namespace gyrotherm::app
